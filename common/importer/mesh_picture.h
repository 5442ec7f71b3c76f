#pragma once

#include <filesystem>

#include "common/error/error.h"
#include "common/mesh/tri_mesh.h"

namespace haptics {

/// Writes a PNG file of the mesh seen from above in front and from below behind, side by side, z up, as large as fits. Faces
/// seen from outside are grey; those seen from their back, through a gap or because they are turned over, are orange; edges
/// of one face alone are blue. Needs no display. Refused: a file that cannot be written.
[[nodiscard]] Result<void> writePicture(const TriMesh& mesh, const std::filesystem::path& file);

}  // namespace haptics

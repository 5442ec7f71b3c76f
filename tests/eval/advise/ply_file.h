#pragma once

#include <string>

#include "common/mesh/tri_mesh.h"

namespace haptics::eval {

/// The mesh as a file, PLY in little-endian: coordinates keep their bits.
[[nodiscard]] std::string plyOf(const TriMesh& mesh);

}  // namespace haptics::eval

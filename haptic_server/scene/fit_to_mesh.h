#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/error/error.h"
#include "common/mesh/tri_mesh.h"
#include "common/scene/deformation_properties.h"
#include "common/scene/surface_edits.h"
#include "common/scene/surface_properties.h"

namespace haptics {

/// Sees that the properties fit the mesh, and gives a lattice whose box was left out that of the mesh. The error that there
/// is names the field below Deformation: a falloff that reaches beyond the object, a mesh that is not within the lattice.
[[nodiscard]] std::optional<Error> fitToMesh(DeformationProperties& properties, const TriMesh& mesh,
                                             bool latticeOfMesh);

/// Triangles that the lattice leaves without an area.
[[nodiscard]] std::size_t flattenedBy(const Lattice& lattice, const TriMesh& mesh);

/// Warnings of a mesh too coarse to show its dents, and of triangles that the lattice leaves without an area, which are
/// counted unless they are known.
[[nodiscard]] std::vector<std::string> deformationWarnings(const DeformationProperties& properties, const TriMesh& mesh,
                                                           std::optional<std::size_t> flattened = std::nullopt);

/// Completes a mapping's intermediate surface by the box of the mesh in its frame.
void fitToMesh(const MappedSource& source, const TriMesh& mesh, Mapping& mapping);

}  // namespace haptics

#pragma once

#include <cstddef>

#include "common/mesh/tri_mesh.h"

namespace haptics::eval {

/// A copy of about so many triangles by quadric error (Garland and Heckbert, Surface Simplification Using Quadric Error
/// Metrics, 1997), through OpenMesh, which flips no face. More triangles remain where no more edge can be collapsed.
/// OpenMesh leaves out faces at which the mesh is not manifold.
[[nodiscard]] TriMesh decimated(const TriMesh& mesh, std::size_t triangles);

/// A copy that strays no farther, of its longest side, is the same shape.
inline constexpr double kExact_of_longest = 1e-6;
/// A copy whose surface is the same within kExact_of_longest: flat faces, and lines between them, of no more triangles
/// than they need.
[[nodiscard]] TriMesh merged(const TriMesh& mesh);

}  // namespace haptics::eval

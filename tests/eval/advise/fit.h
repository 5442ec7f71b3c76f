#pragma once

#include "common/mesh/tri_mesh.h"
#include "haptic_server/geometry/collision_mesh.h"

namespace haptics::eval {

/// Largest distance (m) of a vertex of `mesh` from a surface.
[[nodiscard]] double deviationOf(const TriMesh& mesh, const CollisionMesh& surface);

/// Moves a copy's vertices so that the original's vertices lie nearest to it, in the least-squares sense: decimation keeps
/// vertices where they were, so that a copy of a convex body lies inside of it throughout. Kept only where the largest
/// deviation shrinks.
[[nodiscard]] TriMesh fitted(TriMesh copy, const TriMesh& original);

}  // namespace haptics::eval

#pragma once

#include <cstddef>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// At most about so many of them, evenly spread over their order.
[[nodiscard]] std::vector<Vec3f> everyNth(const std::vector<Vec3f>& vertices, std::size_t most);

/// Largest distance (m) of these places from a surface.
[[nodiscard]] double deviationOf(const std::vector<Vec3f>& places, const CollisionMesh& surface);

/// Moves a copy's vertices so that these places of the original's surface lie nearest to it, in the least-squares sense:
/// decimation keeps vertices where they were, so that a copy of a convex body lies inside of it throughout. Kept only where
/// the largest deviation shrinks.
[[nodiscard]] TriMesh fitted(TriMesh copy, const std::vector<Vec3f>& original);

}  // namespace haptics

#pragma once

#include "common/maths/vec.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// Winding number of a closed surface about `at` (its frame, metres): 0 outside, 1 inside, more where the surface passes
/// through itself, -1 in a room that is bounded by a surface turned inside out. The signed crossings of a ray that leaves
/// the box by its nearest face, aslant to all axes so that it meets no edge of a regular mesh. One query of the hierarchy.
/// The answer of one that has spent the allowance means nothing, here and below.
[[nodiscard]] int windingNumber(const CollisionMesh& surface, Vec3 at, Allowance& allowance) noexcept;

/// On a way from a place about which the surface winds (`winding` more than 0) to one that is outside of its box: the
/// fraction of the way at which the winding number is 0 for the first time.
[[nodiscard]] double leavesAt(const CollisionMesh& surface, int winding, Vec3 from, Vec3 to,
                              Allowance& allowance) noexcept;

}  // namespace haptics

#pragma once

#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// Polygons that one query may look at; near boxes come first, so that what is left out seldom matters. It bounds the
/// tick to some 100 us.
inline constexpr int kNearestBudget = 4096;

/// The point of the whole mesh closest to h (object frame, metres), where it is within `reach_m`; else its triangle is
/// kNoTriangle. A triangle that is likely near, `hint`, makes the query quick; kNoTriangle when none is known. Bounded
/// work, no allocation: of a query that spends the allowance, the best of what it looked at.
[[nodiscard]] ClosestPoint nearestPoint(const CollisionMesh& surface, Vec3 h, double reach_m, std::uint32_t hint,
                                        Allowance& allowance) noexcept;

}  // namespace haptics

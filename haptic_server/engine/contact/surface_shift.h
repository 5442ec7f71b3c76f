#pragma once

#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// How far a surface takes a place with it (its frame, metres) that its vertices come by, from where they were (`before`) to where
/// they are (`now`); `farthest_m`: no vertex goes farther. It is the way of the surface point nearest to the place, and none where
/// the surface does not come by: that is farther off than twice `farthest_m`.
///
/// The place stays on its side. Let p be the place, f its nearest surface point before, and let w, the way of each surface point,
/// change by less than half of the distance from point to point: |w(q) - w(f)| < |q - f| / 2. At any time s of the way
/// |q + s w(q) - p - s w(f)| >= |q - p| - s |w(q) - w(f)| > |q - p| - |q - f| / 2 >= |q - p| - (|q - p| + |f - p|) / 2 >= 0, as
/// |f - p| <= |q - p|: the surface does not meet the place on the way.
///
/// Bounded by the allowance; the answer of a query that spends it means nothing.
[[nodiscard]] Vec3 surfaceShift(const CollisionMesh& before, const CollisionMesh& now, Vec3 place, double farthest_m,
                                Allowance& allowance) noexcept;

/// Where a point of one of its triangles is by now.
[[nodiscard]] Vec3 movedWith(const TriangleRecord& before, const TriangleRecord& now, Vec3 point) noexcept;

}  // namespace haptics

#pragma once

#include "common/maths/fields.h"
#include "haptic_server/engine/collision/body_pairs.h"

namespace haptics {

/// Room for what one search finds. Not initialised, but for the count.
using ManyNear = Sequence<NearPoint, 384>;

/// How far from a surface contacts are looked for, m.
struct NearRange {
  double range_m;    ///< Above it,
  double deepest_m;  ///< and below.
};

/// Finds the places where a polytope and a mesh are near each other, triangle by triangle: where the surface bends outward by
/// the nearest places of the two, else by the corners of the polytope that are above a triangle. Wait-free.
/// @param pose  Of the solid in the ground's frame.
/// @return False: there are too many.
[[nodiscard]] bool findOnMesh(const Collider& solid, const Collider& ground, const Pose& pose, bool solidIsFirst,
                              const NearRange& reach, ManyNear& near, Allowance& allowance) noexcept;

}  // namespace haptics

#pragma once

#include "common/maths/fields.h"
#include "haptic_server/engine/collision/body_pairs.h"
#include "haptic_server/engine/collision/polytope_contact.h"

namespace haptics {

/// Room for what one search finds. Not initialised, but for the count.
using ManyNear = Sequence<NearPoint, 384>;

/// What a search for contacts on a surface keeps to.
struct NearRange {
  double deepest_m;  ///< Farther below the surface none are looked for.
  double period_s;
  PolytopeWay way;          ///< Of the solid; in the ground's frame, without the last normal.
  bool isOneOfTwo = false;  ///< As PolytopeContact::isOneOfTwo, of what was left out; it is filled in.
};

/// Finds the places where a polytope and a mesh are near each other, triangle by triangle: where the surface bends outward by
/// the nearest places of the two, else by the corners of the polytope that are above a triangle. Wait-free.
/// Sides of what is level with the solid are left out, as between polytopes.
/// @param pose  Of the solid in the ground's frame.
/// @return False: there are too many.
[[nodiscard]] bool findOnMesh(const Collider& solid, const Collider& ground, const Pose& pose, bool solidIsFirst,
                              NearRange& reach, ManyNear& near, Allowance& allowance) noexcept;

}  // namespace haptics

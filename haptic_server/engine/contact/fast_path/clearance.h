#pragma once

#include <algorithm>
#include <span>

#include "haptic_server/engine/contact/contact.h"

namespace haptics {

/// Bound on how far a point of the body has moved since the last tick.
[[nodiscard]] double largestMotion_m(const Body& body) noexcept;

/// Is a free HIP at `hip` (world, metres) still in its clearance, reduced by what bodies have moved since the last
/// tick? Then it has met nothing on the way.
[[nodiscard]] inline bool staysClear(std::span<const Body> bodies, ContactState& state, const Vec3& hip) noexcept {
  double motion_m = 0;
  for (const Body& body : bodies) {
    if (body.moving) [[unlikely]]
      motion_m = std::max(motion_m, largestMotion_m(body));
  }
  Clearance& clear = state.clear;
  clear.radius_m -= motion_m;
  if (clear.radius_m > 0 && squaredLength(hip - clear.centre) < clear.radius_m * clear.radius_m) return true;
  clear.radius_m = 0;
  return false;
}

/// After a tick that ended free: sets the clearance to the distance of the nearest triangle, where the HIP, as fast as
/// in this tick, needs a while to get there.
/// @param step_m  That the HIP went in the tick.
void lookForClearance(std::span<const Body> bodies, ContactState& state, double step_m, Allowance& allowance) noexcept;

}  // namespace haptics

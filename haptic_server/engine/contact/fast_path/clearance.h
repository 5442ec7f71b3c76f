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

/// Is the HIP of this tick, which stays in its clearance, about to leave it?
[[nodiscard]] inline bool isNearRim(const Clearance& clear, const Vec3& hip) noexcept {
  constexpr double kShare = 0.75;  // of the squared radius: a HIP as slow as a clearance is looked for comes by
  return squaredLength(hip - clear.centre) > kShare * (clear.radius_m * clear.radius_m);
}

/// After a tick that ended free: sets the clearance to the distance of the nearest triangle, where the HIP, as fast as
/// in this tick, needs a while to get there.
/// @param before  Where the HIP was in the last tick.
void lookForClearance(std::span<const Body> bodies, ContactState& state, const Vec3& before,
                      Allowance& allowance) noexcept;

}  // namespace haptics

#pragma once

#include "haptic_server/engine/step/haptic_state.h"

namespace haptics {

/// Speed of the HIP away from the surface, m/s: along `direction`, relative to the body at the place (both world).
[[nodiscard]] inline double separationSpeed(const HapticState& state, int body, Vec3 place, Vec3 direction,
                                            double period_s) noexcept {
  Vec3 relative = state.estimate.velocity.velocity();
  const Body& touched = state.bodies[static_cast<std::size_t>(body)];
  if (touched.moving) {
    const Vec3 local = toLocal(touched.current, place);
    relative -= (place - toWorld(touched.previous, local - touched.shift)) / period_s;
  }
  return glm::dot(relative, direction);
}

}  // namespace haptics

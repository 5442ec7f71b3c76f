#include "haptic_server/device/usb/usb_protocol.h"

#include <algorithm>
#include <cmath>

namespace haptics {

std::array<std::int16_t, 3> motorNumbers(Vec3 wanted, double limit) noexcept {
  const double largest = std::max({std::abs(wanted.x), std::abs(wanted.y), std::abs(wanted.z)});
  if (!std::isfinite(largest)) return {};
  if (largest > limit) wanted *= limit / largest;
  return {static_cast<std::int16_t>(std::lround(wanted.x)), static_cast<std::int16_t>(std::lround(wanted.y)),
          static_cast<std::int16_t>(std::lround(wanted.z))};
}

}  // namespace haptics

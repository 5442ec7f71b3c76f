#include "haptic_server/device/usb/usb_protocol.h"

#include <algorithm>
#include <cmath>

namespace haptics {

void sendAgain(UsbPort& port, UsbBus& bus, std::span<const std::uint8_t> command, int times) {
  constexpr std::uint64_t kPause_ns = 2'000'000;
  for (int i = 0; i < times && port.send(command) != UsbOutcome::kGone; ++i) {
    const std::uint64_t until_ns = bus.clock_ns() + kPause_ns;
    while (bus.clock_ns() < until_ns && port.next(until_ns).kind != UsbArrival::Kind::kGone) {
    }
  }
}

std::array<std::int16_t, 3> motorNumbers(Vec3 wanted, double limit) noexcept {
  const double largest = std::max({std::abs(wanted.x), std::abs(wanted.y), std::abs(wanted.z)});
  if (!std::isfinite(largest)) return {};
  if (largest > limit) wanted *= limit / largest;
  return {static_cast<std::int16_t>(std::lround(wanted.x)), static_cast<std::int16_t>(std::lround(wanted.y)),
          static_cast<std::int16_t>(std::lround(wanted.z))};
}

}  // namespace haptics

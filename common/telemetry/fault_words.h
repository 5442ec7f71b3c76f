#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "common/telemetry/telemetry_sample.h"

namespace haptics {

/// Why the force was taken away, as people read it; the device's own account where it has one.
[[nodiscard]] constexpr const char* faultInWords(Fault fault, DeviceFault device) noexcept {
  switch (fault) {
    case Fault::kNone:
      return "none";
    case Fault::kNonFiniteInput:
      return "the device's position is not finite, or more than 10 km away";
    case Fault::kNonFiniteForce:
      return "the force is not finite";
    case Fault::kDeadlinesMissed:
      return "too many ticks were missed in a row";
    case Fault::kDeviceStale:
      return device == DeviceFault::kNone ? "the device's position is old" : inWords(device);
    case Fault::kDeviceLost:
      return device == DeviceFault::kNone ? "the device is not ready" : inWords(device);
  }
  return "unknown";
}

/// TelemetrySample::wait_s in words, for the end of a line; empty at 0.
[[nodiscard]] inline std::string waitInWords(double wait_s) {
  if (!(wait_s > 0)) return {};
  return ", again and again: back in " + std::to_string(static_cast<int>(std::ceil(std::min(wait_s, 1e6)))) + " s";
}

}  // namespace haptics

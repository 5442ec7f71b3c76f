#pragma once

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

}  // namespace haptics

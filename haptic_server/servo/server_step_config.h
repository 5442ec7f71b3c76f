#pragma once

#include "haptic_server/device/device.h"
#include "haptic_server/step/haptic_state.h"

namespace haptics {

/// The observer for a device at a servo rate.
[[nodiscard]] ObserverSettings leadFor(const DeviceInfo& device, double rate_Hz) noexcept;

/// With what the server feels by default: the device's limits, and with the stabiliser. rate_Hz > 0.
[[nodiscard]] StepConfig serverStepConfig(const DeviceInfo& device, double rate_Hz) noexcept;

}  // namespace haptics

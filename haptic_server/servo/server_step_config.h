#pragma once

#include "haptic_server/device/device.h"
#include "haptic_server/engine/step/haptic_state.h"

namespace haptics {

/// The observer for a device at a servo rate.
[[nodiscard]] ObserverSettings observerFor(const DeviceInfo& device, double rate_Hz) noexcept;

/// The server's default: the device's limits, and its observers (the stabiliser) unless that is off. rate_Hz > 0.
[[nodiscard]] StepConfig serverStepConfig(const DeviceInfo& device, double rate_Hz, bool stabilised = true);

}  // namespace haptics

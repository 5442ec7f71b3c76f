#pragma once

#include "haptic_server/device/presets.h"
#include "haptic_server/servo/haptic_state.h"

namespace haptics::eval {

/// As the server's loop has it under this device, but that the force is left to the device to limit.
[[nodiscard]] StepConfig stepConfigFor(const DevicePreset& device, double rate_Hz);

}  // namespace haptics::eval

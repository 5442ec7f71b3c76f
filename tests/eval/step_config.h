#pragma once

#include "haptic_server/device/presets.h"
#include "haptic_server/engine/step/haptic_state.h"

namespace haptics::eval {

/// As the server's loop has it under this device with --no-stabiliser, but that the force is left to the device to limit:
/// for scripted places, which no force moves.
[[nodiscard]] StepConfig stepConfigFor(const DevicePreset& device, double rate_Hz);

/// What the server runs by default under this device, its stabiliser included, but that the force is there from the first
/// tick on. @param delay_s  As the server is told.
[[nodiscard]] StepConfig serverConfigFor(const DevicePreset& device, double rate_Hz, double delay_s = 0);

/// The device without its rotation, which a point does not feel.
[[nodiscard]] DevicePreset withoutRotation(DevicePreset device);

}  // namespace haptics::eval

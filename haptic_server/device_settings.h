#pragma once

#include "haptic_server/device/device.h"
#include "haptic_server/engine/step/haptic_state.h"
#include "haptic_server/scene/surface_warnings.h"
#include "haptic_server/server_options.h"

namespace haptics {

/// The step's configuration for the device, as the command line changes it.
[[nodiscard]] StepConfig stepConfigOf(const ServerOptions& options, const DeviceInfo& device, double rate_Hz);

/// The device's limits, for clamps of the scene's materials. May search for seconds where it was never asked for such a
/// device; the log says what came of it.
[[nodiscard]] DeviceLimits limitsOf(const ServerOptions& options, const DeviceInfo& device, const StepConfig& step,
                                    double rate_Hz);

/// Of a scene that two hands feel: what both devices bear.
[[nodiscard]] DeviceLimits ofBoth(const DeviceLimits& first, const DeviceLimits& second);

}  // namespace haptics

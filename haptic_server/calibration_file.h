#pragma once

#include <string>

#include "common/error/error.h"
#include "haptic_server/device/usb/calibration.h"

namespace haptics {

/// A DeviceCalibration of proto/haptics/v1/device.proto in text format. Refused, naming file, line and field: keys that do
/// not exist, and values out of range.
[[nodiscard]] Result<DeviceCalibration> readCalibration(const std::string& file);
[[nodiscard]] Result<DeviceCalibration> parseCalibration(const std::string& text, const std::string& origin);

}  // namespace haptics

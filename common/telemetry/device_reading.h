#pragma once

#include "common/maths/vec.h"
#include "common/telemetry/added_wrench.h"
#include "common/telemetry/handle_reading.h"
#include "common/telemetry/telemetry_sample.h"

namespace haptics {

/// Of a device's reading, what forces are computed from.
struct DevicePose {
  Vec3 position{0};  ///< Metres, world frame.
  DeviceState state = DeviceState::kAbsent;
  /// Not felt through where it names a fault, is not homed, or is older than the servo's watchdog allows.
  DeviceStatus status{};
  Quat rotation{1, 0, 0, 0};  ///< Length 1, world frame: (1, 0, 0, 0) of a device that does not sense it.
  double gripper_rad = 0;     ///< How far its gripper is open; 0: closed, or it has none.
};

struct DeviceReading : DevicePose {
  HandleReading handle{};
  AddedWrench added{};
};

}  // namespace haptics

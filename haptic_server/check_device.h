#pragma once

namespace haptics {

/// haptic_server check-device: brings a device up without a server, and says what is wrong with it (bring_up/device_check.h); a
/// report to send. 0: all is well.
[[nodiscard]] int runCheckDevice(int argc, char** argv);

}  // namespace haptics

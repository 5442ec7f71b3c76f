#pragma once

namespace haptics {

/// haptic_server check-device: brings a device up without a server, and says how often, how late and how finely it tells
/// its position, which way its forces push, and how soon they end; a report to paste. 0: all is well.
[[nodiscard]] int runCheckDevice(int argc, char** argv);

}  // namespace haptics

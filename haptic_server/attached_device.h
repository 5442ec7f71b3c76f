#pragma once

#include <iosfwd>
#include <memory>

#include "common/error/error.h"
#include "common/telemetry/hand_command.h"
#include "haptic_server/device/device.h"
#include "haptic_server/device/usb/output_watchdog.h"
#include "haptic_server/recording/recording_player.h"
#include "haptic_server/server_options.h"
#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// The device that a server was asked for, with what it needs to live: a hand, or a bus and a driver thread.
class AttachedDevice {
 public:
  /// Refused, naming option or node: a device that is not there or may not be opened, several without a choice, a rate that
  /// it cannot do, a firmware or calibration file that is none, a recording that is none.
  [[nodiscard]] static Result<std::unique_ptr<AttachedDevice>> attach(const ServerOptions& options);
  virtual ~AttachedDevice() = default;

  [[nodiscard]] virtual Device& device() noexcept = 0;
  /// Before start(): who takes its force away when this process no longer can; outlives it.
  virtual void setWatchdog(OutputWatchdog& /*watchdog*/) {}
  /// Its threads, where it has any; once, before the servo's. Warns when they cannot be real-time ones.
  virtual void start() {}
  /// Where the device is a recording: the servo runs its ticks and has its scenes. Else null.
  [[nodiscard]] virtual RecordingPlayer* player() noexcept { return nullptr; }
  /// For the hand of a simulated device. False: a person holds it, or it is a recording.
  [[nodiscard]] virtual bool commandHand(const HandCommand& /*command*/) { return false; }
  virtual void fillStatus(v1::Status& /*status*/) const {}
};

/// Is it a name that --device takes, with or without what comes after the colon?
[[nodiscard]] bool isDeviceName(const std::string& name);

/// The text of --list-devices: devices on USB and those of our own plug-ins, whether they may be opened, and how to choose each.
void listDevices(std::ostream& out);

}  // namespace haptics

#pragma once

#include <cstdint>

namespace haptics {

/// Why a device cannot be felt through; values equal those of the wire's enum (telemetry.proto).
enum class DeviceFault : std::uint8_t {
  kNone = 0,
  kNotFound = 1,      ///< None on the bus.
  kAmbiguous = 2,     ///< Several, and none was chosen.
  kNotPermitted = 3,  ///< The node may not be opened.
  kInUse = 4,         ///< Another program has it.
  kFirmware = 5,      ///< Its firmware could not be loaded.
  kNotAnswering = 6,  ///< It does not answer the first request.
  kUnplugged = 7,     ///< The device was unplugged.
  kSilent = 8,        ///< Nothing comes from it.
  kGarbled = 9,       ///< Its bytes are no complete reply.
  kStalled = 10,      ///< It refuses transfers.
  kLate = 11,         ///< Replies come, but those to requests of long ago.
  kHomingLost = 12,   ///< It says that it no longer knows where it is.
  kJumped = 13,       ///< A position that no hand can have moved it to.
  kWatchdog = 14,     ///< The watchdog took the force away.
  kForceOff = 15,     ///< The device took its force away by itself.
};
inline constexpr DeviceFault kLastDeviceFault = DeviceFault::kForceOff;

/// What buttons are bound to; bits of DeviceStatus::actions.
enum class HandAction : std::uint8_t {
  kClutch = 1,    ///< The hand moves its workspace: the pose stays where it is, and there is no force.
  kGrasp = 2,     ///< It holds the body that it touched on pressing.
  kMark = 4,      ///< The recording is marked.
  kNextTool = 8,  ///< On pressing it takes the scene's next tool.
  kNoOther = 16,  ///< All of the pressed buttons are bound: none is left to trigger an effect.
};
inline constexpr std::uint8_t kAllHandActions = 31;

/// A device's own account of itself, as of one reading. A device that exists only in memory has nothing to report.
struct DeviceStatus {
  DeviceFault fault = DeviceFault::kNone;
  bool homed = true;           ///< Its coordinates are referenced; no force before that.
  std::uint8_t homedAxes = 0;  ///< Bit per axis, as far as the device tells them apart.
  std::uint8_t actions = 0;    ///< Bit per HandAction whose button is pressed.
  std::uint32_t buttons = 0;   ///< Bit per button.
  std::uint32_t age_us = 0;    ///< Of the position, when it was read.

  [[nodiscard]] bool does(HandAction action) const noexcept {
    return (actions & static_cast<std::uint8_t>(action)) != 0;
  }
  void set(HandAction action, bool on) noexcept {
    const auto bit = static_cast<std::uint8_t>(action);
    actions = static_cast<std::uint8_t>(on ? actions | bit : actions & ~bit);
  }

  bool operator==(const DeviceStatus&) const = default;
};

/// The fault as people read it: "the device was unplugged".
[[nodiscard]] constexpr const char* inWords(DeviceFault fault) noexcept {
  switch (fault) {
    case DeviceFault::kNone:
      return "the device works";
    case DeviceFault::kNotFound:
      return "no such device is plugged in";
    case DeviceFault::kAmbiguous:
      return "several such devices are plugged in";
    case DeviceFault::kNotPermitted:
      return "no permission to open the device";
    case DeviceFault::kInUse:
      return "another program uses the device";
    case DeviceFault::kFirmware:
      return "the firmware could not be loaded";
    case DeviceFault::kNotAnswering:
      return "the device does not answer";
    case DeviceFault::kUnplugged:
      return "the device was unplugged";
    case DeviceFault::kSilent:
      return "the device fell silent";
    case DeviceFault::kGarbled:
      return "the device's replies are garbled";
    case DeviceFault::kStalled:
      return "the device refuses transfers";
    case DeviceFault::kLate:
      return "the device's replies come late";
    case DeviceFault::kHomingLost:
      return "the device lost its homing";
    case DeviceFault::kJumped:
      return "the device's position jumped";
    case DeviceFault::kWatchdog:
      return "the servo stood still, and the watchdog took the force away";
    case DeviceFault::kForceOff:
      return "the device took its force away by itself";
  }
  return "unknown";
}

}  // namespace haptics

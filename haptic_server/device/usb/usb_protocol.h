#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>

#include "haptic_server/device/device.h"
#include "haptic_server/device/usb/calibration.h"
#include "haptic_server/device/usb/usb_port.h"

namespace haptics {

/// From a position to the motors' force that it led to, beyond the hold: the reply to a command lies ready for the next
/// tick, and that tick's command goes out right after it. Of emulated hardware.
inline constexpr double kExchangeDelay_s = 1e-3;

/// One reply of a device, decoded.
struct DeviceReply {
  std::array<std::int16_t, 3> counts{};
  std::uint32_t buttons = 0;
  std::uint8_t homedAxes = 0;  ///< kAllAxes: its coordinates are referenced.
  std::uint32_t age_us = 0;    ///< When it arrived, by the device's own account.
  bool forceOff = false;       ///< It took its force away by itself.
};
inline constexpr std::uint8_t kAllAxes = 0b111;

/// What the device shows.
enum class DeviceLight : std::uint8_t { kOff, kHoming, kReady, kFault };

/// What the driver needs to know of one kind of device. The driver thread's alone; keeps the state of one connection,
/// begun by start().
class UsbProtocol {
 public:
  virtual ~UsbProtocol() = default;
  [[nodiscard]] virtual const UsbModel& model() const noexcept = 0;
  /// As the servo sees it: in the world, after calibration.
  [[nodiscard]] virtual const DeviceInfo& info() const noexcept = 0;
  [[nodiscard]] virtual const Placement& placement() const noexcept = 0;
  /// What a person has to do, until it is homed.
  [[nodiscard]] virtual std::string_view homingGuide() const noexcept = 0;
  /// Does it reply to each command, and to nothing else? Else it reports by itself.
  [[nodiscard]] virtual bool answersEachCommand() const noexcept = 0;

  /// Brings a device that was just opened to where it replies. Takes seconds where firmware is to be loaded.
  [[nodiscard]] virtual std::optional<UsbRefusal> start(UsbPort& port, UsbBus& bus) = 0;

  /// Its coordinates turned out to be wrong: the next start() has it homed anew.
  virtual void invalidateHoming() noexcept = 0;

  /// Decodes what arrived; calls `found` for each reply in it. True if anything in it was no part of a reply.
  [[nodiscard]] virtual bool take(std::span<const std::uint8_t> bytes,
                                  const std::function<void(const DeviceReply&)>& found) = 0;
  /// Position (metres, device frame) of the newest reply; none where no pose of the device gives these counts.
  [[nodiscard]] virtual std::optional<Vec3> locate(const DeviceReply& reply) = 0;
  /// How it is turned in the newest reply that was located, device frame; upright where it does not sense that.
  [[nodiscard]] virtual Quat rotation() const noexcept { return {1, 0, 0, 0}; }
  /// What else was measured with it; vectors in the device's frame.
  [[nodiscard]] virtual HandleReading handle() const noexcept { return {}; }
  /// On the hand, device frame, and on the gripper, which it opens above 0, in commands from now on.
  virtual void setTorque(Vec3 /*torque_Nm*/, double /*grip_Nm*/) noexcept {}
  /// The command that pushes the hand with a force (newtons, device frame) where it was located last. Valid until the
  /// next call.
  [[nodiscard]] virtual std::span<const std::uint8_t> command(Vec3 force_N, DeviceLight light) = 0;
};

/// Sends a command again and again, 2 ms apart, and drops what comes meanwhile: for what has to arrive.
void sendAgain(UsbPort& port, UsbBus& bus, std::span<const std::uint8_t> command, int times);

/// Numbers for three motors, shortened together so that none exceeds the limit: the direction is kept.
[[nodiscard]] std::array<std::int16_t, 3> motorNumbers(Vec3 wanted, double limit) noexcept;

}  // namespace haptics

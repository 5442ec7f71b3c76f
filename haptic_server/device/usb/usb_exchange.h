#pragma once

#include <atomic>
#include <optional>

#include "haptic_server/device/usb/link_watch.h"
#include "haptic_server/device/usb/usb_device.h"

namespace haptics {

/// The running exchange with a device that was brought to work: commands out at the servo's pace, replies in as they
/// come. The driver thread's.
class UsbExchange {
 public:
  /// After the servo wrote, so long until the command goes out (ns): more than its jitter, so that a command carries this
  /// tick's force and the reply is there before the next tick.
  static constexpr std::int64_t kAfterServo_ns = 100'000;
  static constexpr std::uint64_t kLookAgain_ns = 50'000;  ///< Between looks for the force of a servo that is late.
  /// A servo that wrote nothing for longer has died: the force is taken away.
  static constexpr std::uint64_t kServoSilence_ns = 25'000'000;
  /// A device with a fault that lasts longer is closed and brought up anew.
  static constexpr std::uint64_t kGiveUp_ns = 1'000'000'000;
  /// No hand moves it faster: beyond it, its coordinates have jumped, and are not believed until they have jumped back
  /// to within kSameAgain_m, or it was homed anew.
  static constexpr double kMaxSpeed_m_per_s = 5;
  static constexpr double kSameAgain_m = 0.002;
  /// No hand, nor the end of its travel at 2 m/s, changes its velocity faster: what a position is off the way that it was on
  /// by more than kMaxChange_m_per_s2 dt^2, and kSameAgain_m, is a jump too.
  static constexpr double kMaxChange_m_per_s2 = 2'000;
  static constexpr double kMaxTurn_rad_per_s = 50;  ///< The same of how it is turned.
  static constexpr double kSameAgain_rad = 0.05;
  static constexpr int kHomedReplies = 25;  ///< In a row, that must say that it is homed.

  UsbExchange(UsbBus& bus, UsbPort& port, UsbProtocol& protocol, UsbShared& shared, const UsbDeviceSettings& settings);

  /// Until `quit`, or until the device is gone or to be brought up anew. Once `stopped`, or at the end, the motors are
  /// off.
  void run(const std::atomic<bool>& quit, const std::atomic<bool>& stopped);

 private:
  [[nodiscard]] bool handleTrip(std::uint64_t now_ns);
  void sendCommand(std::uint64_t now_ns, bool stopped);
  [[nodiscard]] bool receiveUntil(std::uint64_t deadline_ns);
  [[nodiscard]] bool receiveUntilOrdered(std::uint64_t deadline_ns);
  void take(const DeviceReply& reply, std::uint64_t now_ns);
  void watchHoming(const DeviceReply& reply);
  void watchMove(Vec3 to, Quat rotation, std::uint64_t now_ns) noexcept;
  [[nodiscard]] bool hasJumped() const noexcept;
  void judge(std::uint64_t now_ns);
  [[nodiscard]] std::uint64_t nextDeadline(std::uint64_t last_ns) noexcept;

  UsbBus& bus_;
  UsbPort& port_;
  UsbProtocol& protocol_;
  UsbShared& shared_;
  const UsbDeviceSettings& settings_;

  std::uint64_t period_ns_;
  LinkWatch watch_;
  OutputGain gain_;
  DeviceReport report_;
  DeviceFault fault_ = DeviceFault::kNone;
  std::uint64_t faultSince_ns_ = 0;
  std::uint64_t ordered_ns_ = 0;  // DeviceOrder::written_ns of the last command
  std::uint64_t trips_ = 0;       // OutputWatchdog::trips(), handled or not,
  std::uint64_t tripped_ns_ = 0;  // and when that was seen
  std::optional<Vec3> position_;  // of the last reply, device frame
  Quat rotation_{1, 0, 0, 0};     // likewise
  Vec3 velocity_{0};              // m/s, of the last move that was no jump
  std::uint64_t positioned_ns_ = 0;
  Vec3 jumped_{0}, jumped_rad_{0};  // sum of all jumps
  std::uint64_t cycleBegan_ns_ = 0, longestCycle_ns_ = 0;
  int homedReplies_ = 0;
  bool guided_ = false;
  bool gone_ = false;
  bool homingLost_ = false;
  bool silenced_ = false;  // the last command was without force
};

}  // namespace haptics

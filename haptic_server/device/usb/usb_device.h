#pragma once

#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "common/mailbox/triple_buffer.h"
#include "haptic_server/device/device.h"
#include "haptic_server/device/usb/output_watchdog.h"
#include "haptic_server/device/usb/usb_port.h"
#include "haptic_server/device/usb/usb_protocol.h"

namespace haptics {

/// What the driver tells the servo. World frame.
struct DeviceReport {
  Vec3 position{0};
  Quat rotation{1, 0, 0, 0};
  HandleReading handle{};
  DeviceState state = DeviceState::kAbsent;
  DeviceStatus status{.fault = DeviceFault::kNotFound, .homed = false};
  std::uint64_t arrived_ns = 0;  ///< The reply with this position.
  std::uint64_t replies = 0;     ///< Up to this one.
};

/// What the servo tells the driver.
struct DeviceOrder {
  Vec3 force_N{0};     ///< On the hand, world frame.
  Vec3 torque_Nm{0};   ///< Likewise.
  double grip_Nm = 0;  ///< On the gripper, which it opens above 0.
  std::uint64_t written_ns = 0;
};

/// Counters of a device on USB since start. The driver and the servo count, any thread reads.
struct UsbDeviceCounters {
  std::atomic<std::uint64_t> commands{0};     ///< Sent.
  std::atomic<std::uint64_t> replies{0};      ///< Whole ones.
  std::atomic<std::uint64_t> used{0};         ///< Of those, read by the servo.
  std::atomic<std::uint64_t> garbled{0};      ///< Packets with bytes that were no part of a reply.
  std::atomic<std::uint64_t> connections{0};  ///< Times that it was brought to work.
  std::atomic<std::uint64_t> faults{0};       ///< Times that it stopped to.
};

/// What the driver shares with the servo, the watchdog and those who ask for a status.
struct UsbShared {
  TripleBuffer<DeviceReport> reports;
  TripleBuffer<DeviceOrder> orders;
  UsbDeviceCounters counters;
  OutputWatchdog* watchdog = nullptr;
  /// OutputWatchdog::trips() after which the driver has taken the force away too.
  std::atomic<std::uint64_t> handledTrips{0};
};

struct UsbDeviceSettings {
  std::string wanted;       ///< Serial number, "BUS/ADDRESS" or port path; empty: the only one.
  double period_s = 1e-3;   ///< Of the servo.
  double maxRate_Hz = 1e3;  ///< Exchanges a second that the link can carry; of USB kMaxRate_Hz.
  std::function<void(const std::string&)> info, warning;  ///< Lines for the log, from the driver's thread.
};

/// The driver of a device on USB. It runs on a thread of its own, because libusb takes locks and memory, and exchanges the
/// newest position and force with the servo through mailboxes: read, write and stop are wait-free.
///
/// Commands go out at the servo's pace, soon after it wrote (1 kHz at most: a full-speed bus has one frame a
/// millisecond), and never wait for a reply; one waits for a servo that is late, for half a period. A device that cannot be felt through is driven to zero force at once; when it
/// was unplugged, or says nothing for a second, it is looked for and brought up anew until stop.
class UsbDevice final : public Device {
 public:
  /// Exchanges a second that the bus can carry.
  static constexpr double kMaxRate_Hz = 1'000;

  UsbDevice(UsbBus& bus, std::unique_ptr<UsbProtocol> protocol, UsbDeviceSettings settings);
  ~UsbDevice() override;  ///< Motors off.

  /// Before start(). Outlives the device; without it, nobody takes the force away when the process no longer can.
  void setWatchdog(OutputWatchdog& watchdog) noexcept { shared_.watchdog = &watchdog; }
  /// Starts the thread. `become` is called on it first, to make it a real-time one.
  void start(std::function<void()> become);
  /// The driver itself, until `stop`; start() runs it.
  void drive(const std::atomic<bool>& stop);

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return protocol_->info(); }
  [[nodiscard]] bool hasNewSample() noexcept override { return shared_.reports.newest().replies != repliesRead_; }
  [[nodiscard]] DeviceReading read(std::uint64_t tick) noexcept override;
  void writeTorque(Vec3 torque_Nm) noexcept override { torque_Nm_ = isFinite(torque_Nm) ? torque_Nm : Vec3(0); }
  void writeGrip(double moment_Nm) noexcept override { grip_Nm_ = std::isfinite(moment_Nm) ? moment_Nm : 0; }
  void write(Vec3 force_N) noexcept override;
  void stop() noexcept override;

  [[nodiscard]] const UsbDeviceCounters& counters() const noexcept { return shared_.counters; }

 private:
  UsbBus& bus_;
  std::unique_ptr<UsbProtocol> protocol_;
  UsbDeviceSettings settings_;
  UsbShared shared_;
  std::uint64_t repliesRead_ = 0;  // the servo's
  Vec3 torque_Nm_{0};              // likewise
  double grip_Nm_ = 0;             // likewise
  std::atomic<bool> stopped_{false};
  std::atomic<bool> quit_{false};
  std::thread thread_;
};

}  // namespace haptics

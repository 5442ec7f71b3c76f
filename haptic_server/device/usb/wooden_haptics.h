#pragma once

#include <array>
#include <cstdint>

#include "haptic_server/device/usb/usb_protocol.h"

namespace haptics {

inline constexpr UsbModel kWoodenHapticsModel{
    .vendor = 0x1234, .product = 0x0006, .in = 0x81, .out = 0x01, .interrupt = true};

/// Body angles (rad) of encoder counts since the rest pose, and back.
[[nodiscard]] Vec3 woodenAngles(Vec3 counts) noexcept;
[[nodiscard]] Vec3 woodenCounts(Vec3 angles) noexcept;  ///< Not rounded.

/// WoodenHaptics 1.5: an open-source serial arm of plywood, a HID with reports of 8 bytes. Its encoders count from where
/// it was switched on, so the arm is laid into its rest pose and left still: that is its homing.
class WoodenHaptics final : public UsbProtocol {
 public:
  static constexpr double kMaxForce_N = 5;
  static constexpr double kMaxStiffness_N_per_m = 1'000, kMaxDamping_Ns_per_m = 8;  // as published with the device
  static constexpr double kTorqueConstant_Nm_per_A = 0.0259;
  static constexpr double kMaxCurrent_mA = 3'000;
  /// Reports for which the arm has to lie still, a second's worth; and by how many counts it may tremble.
  static constexpr int kRestingReports = 1'000;
  static constexpr int kRestingCounts = 3;

  explicit WoodenHaptics(const DeviceCalibration& calibration);

  [[nodiscard]] const UsbModel& model() const noexcept override { return kWoodenHapticsModel; }
  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] const Placement& placement() const noexcept override { return placement_; }
  [[nodiscard]] std::string_view homingGuide() const noexcept override {
    return "set the arm to its rest pose (upper arm upright, forearm level, pointing at you) and leave it still for a "
           "second";
  }
  [[nodiscard]] bool answersEachCommand() const noexcept override { return false; }
  [[nodiscard]] std::optional<UsbRefusal> start(UsbPort& port, UsbBus& bus) override;
  void invalidateHoming() noexcept override {}  // each start() begins at the rest pose
  [[nodiscard]] bool take(std::span<const std::uint8_t> bytes,
                          const std::function<void(const DeviceReply&)>& found) override;
  [[nodiscard]] std::optional<Vec3> locate(const DeviceReply& reply) override;
  [[nodiscard]] std::span<const std::uint8_t> command(Vec3 force_N, DeviceLight light) override;

 private:
  void watchRest(const std::array<std::int16_t, 3>& counts) noexcept;

  double forceScale_;
  Vec3 sense_;
  Placement placement_;
  DeviceInfo info_;
  Vec3 angles_;
  std::array<std::int16_t, 3> rest_{};  // counts in the rest pose
  int resting_ = 0;                     // reports for which it has been still
  bool homed_ = false;
  std::array<std::uint8_t, 8> report_{};
};

}  // namespace haptics

#pragma once

#include <optional>

#include "haptic_server/device/usb/falcon_firmware.h"
#include "haptic_server/device/usb/falcon_frame.h"
#include "haptic_server/device/usb/usb_protocol.h"

namespace haptics {

inline constexpr UsbModel kFalconModel{.vendor = 0x0403, .product = 0xCB48, .in = 0x81, .out = 0x02};

/// Encoder counts of the thighs' angles (rad), and back.
[[nodiscard]] Vec3 falconAngles(const std::array<std::int16_t, 3>& counts) noexcept;
[[nodiscard]] Vec3 falconCounts(Vec3 angles) noexcept;  ///< Not rounded.

/// Novint Falcon: a delta robot behind an FT232R serial converter, its controller without a program at power-up.
class Falcon final : public UsbProtocol {
 public:
  /// Motor units per newton metre unless calibrated: the least that is published.
  static constexpr double kMotorUnitsPerNm = 2'400;
  static constexpr double kMotorLimit = 4'095;

  /// `firmware` is loaded where the device has none; without it, such a device is refused.
  Falcon(const DeviceCalibration& calibration, std::optional<FalconFirmware> firmware);

  [[nodiscard]] const UsbModel& model() const noexcept override { return kFalconModel; }
  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] const Placement& placement() const noexcept override { return placement_; }
  [[nodiscard]] std::string_view homingGuide() const noexcept override {
    return "pull the Falcon's grip out towards you as far as it goes, then push it in all the way";
  }
  [[nodiscard]] bool answersEachCommand() const noexcept override { return true; }
  [[nodiscard]] std::optional<UsbRefusal> start(UsbPort& port, UsbBus& bus) override;
  void invalidateHoming() noexcept override { homeAnew_ = true; }
  [[nodiscard]] bool take(std::span<const std::uint8_t> bytes,
                          const std::function<void(const DeviceReply&)>& found) override;
  [[nodiscard]] std::optional<Vec3> locate(const DeviceReply& reply) override;
  [[nodiscard]] std::span<const std::uint8_t> command(Vec3 force_N, DeviceLight light) override;

 private:
  std::optional<FalconFirmware> firmware_;
  double motorUnitsPerNm_;
  double forceScale_;
  Vec3 sense_;
  Placement placement_;
  DeviceInfo info_;
  FalconReplyReader reader_;
  Vec3 position_;
  bool homeAnew_ = false;
  FalconFrame frame_{};
};

}  // namespace haptics

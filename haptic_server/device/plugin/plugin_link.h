#pragma once

#include <functional>
#include <memory>
#include <string>

#include "haptic_server/device/plugin/device_plugin.h"
#include "haptic_server/device/usb/usb_protocol.h"

// A plug-in behind the seam of the drivers: its device is exchanged with, watched and brought up again as one on USB.
namespace haptics {

/// A loaded plug-in, which stays loaded.
class PluginLibrary {
 public:
  /// Refused: no shared library, one without haptics_device_plugin(), one of another version or without a function.
  [[nodiscard]] static Result<PluginLibrary> load(const std::string& file);

  /// Opens and closes the device that WHICH names, to see what it is. Refused: what the plug-in refuses, in its words;
  /// a description out of range, naming the field.
  [[nodiscard]] Result<haptics_device_info> describe(const std::string& which) const;
  [[nodiscard]] const haptics_device_functions& functions() const noexcept { return functions_; }
  [[nodiscard]] const std::string& file() const noexcept { return file_; }

 private:
  PluginLibrary(std::string file, const haptics_device_functions& functions)
      : file_(std::move(file)), functions_(functions) {}

  std::string file_;
  haptics_device_functions functions_;
};

/// Opens the plug-in's device as a port that carries haptics_device_state one way, and a force, a torque and the gripper's moment,
/// seven doubles, the other.
class PluginBus final : public UsbBus {
 public:
  /// @param warning  Is told, from the driver's thread, of calls that took too long.
  PluginBus(PluginLibrary library, std::string which, std::function<void(const std::string&)> warning)
      : library_(std::move(library)), which_(std::move(which)), warning_(std::move(warning)) {}

  [[nodiscard]] std::uint64_t clock_ns() noexcept override;
  void sleepUntil(std::uint64_t time_ns) override;
  [[nodiscard]] std::vector<UsbPlace> list(const UsbModel& model) override;
  [[nodiscard]] tl::expected<std::unique_ptr<UsbPort>, UsbRefusal> open(const UsbModel& model,
                                                                        const UsbPlace& place) override;

 private:
  PluginLibrary library_;
  std::string which_;
  std::function<void(const std::string&)> warning_;
};

/// What the driver needs to know of such a device.
class PluginProtocol final : public UsbProtocol {
 public:
  PluginProtocol(const haptics_device_info& description, const DeviceCalibration& calibration);

  [[nodiscard]] const UsbModel& model() const noexcept override { return model_; }
  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] const Placement& placement() const noexcept override { return placement_; }
  [[nodiscard]] std::string_view homingGuide() const noexcept override { return "home it as its maker says"; }
  [[nodiscard]] bool answersEachCommand() const noexcept override { return false; }
  [[nodiscard]] std::optional<UsbRefusal> start(UsbPort& /*port*/, UsbBus& /*bus*/) override { return std::nullopt; }
  void invalidateHoming() noexcept override {}
  [[nodiscard]] bool take(std::span<const std::uint8_t> bytes,
                          const std::function<void(const DeviceReply&)>& found) override;
  [[nodiscard]] std::optional<Vec3> locate(const DeviceReply& reply) override;
  [[nodiscard]] Quat rotation() const noexcept override { return rotation_; }
  [[nodiscard]] HandleReading handle() const noexcept override { return handle_; }
  void setTorque(Vec3 torque_Nm, double grip_Nm) noexcept override;
  [[nodiscard]] std::span<const std::uint8_t> command(Vec3 force_N, DeviceLight light) override;

 private:
  Placement placement_;
  Vec3 sense_;  // of each axis; of rotations, which a mirror turns the other way, handedness_ times that
  double handedness_;
  double forceScale_;
  DeviceInfo info_;
  UsbModel model_;
  Vec3 position_{0};  // of the newest state
  Quat rotation_{1, 0, 0, 0};
  HandleReading handle_;            // likewise
  std::array<double, 7> output_{};  // N, Nm, Nm
};

}  // namespace haptics

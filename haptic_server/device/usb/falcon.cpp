#include "haptic_server/device/usb/falcon.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include "common/maths/rotation.h"
#include "haptic_server/device/presets.h"
#include "haptic_server/device/usb/delta_kinematics.h"
#include "haptic_server/device/usb/falcon_boot.h"

namespace haptics {
namespace {

constexpr double kEncoderDegree_rad = std::numbers::pi / 180;
constexpr double kZeroAngle = 35 * kEncoderDegree_rad;
constexpr double kFalconCount_rad = 0.0364347 * kEncoderDegree_rad;
constexpr int kForgetCommands = 20;            // it forgets its homing when a command does not ask for it
constexpr std::size_t kModemStatus_bytes = 2;  // at the head of each packet of the serial converter
/// The device's z comes out towards the user, its y is up.
const Quat kFalconUpright = rotationBy(Vec3(std::numbers::pi / 2, 0, 0));

[[nodiscard]] DeviceInfo describeFalcon(const DeviceCalibration& calibration, double scale) {
  const DevicePreset preset = *findDevicePreset("falcon");
  return {std::string(preset.title),
          std::min(preset.maxForce_N, calibration.maxForce_N.value_or(preset.maxForce_N)),
          preset.maxStiffness_N_per_m / scale,
          preset.maxDamping_Ns_per_m / scale,
          preset.resolution_m * scale,
          preset.apparentMass_kg / scale,
          preset.viscousFriction_Ns_per_m / scale,
          preset.coulombFriction_N,
          kExchangeDelay_s};
}

}  // namespace

Vec3 falconAngles(const std::array<std::int16_t, 3>& counts) noexcept {
  return kZeroAngle + kFalconCount_rad * Vec3(counts[0], counts[1], counts[2]);
}

Vec3 falconCounts(Vec3 angles) noexcept { return (angles - kZeroAngle) / kFalconCount_rad; }

Falcon::Falcon(const DeviceCalibration& calibration, std::optional<FalconFirmware> firmware)
    : firmware_(std::move(firmware)),
      motorUnitsPerNm_(calibration.motorUnitsPerNm.value_or(kMotorUnitsPerNm)),
      forceScale_(calibration.forceScale.value_or(1)),
      sense_(calibration.sense()),
      placement_(calibration, kFalconUpright, DeltaKinematics::kCentre),
      info_(describeFalcon(calibration, placement_.scale())),
      position_(DeltaKinematics::kCentre) {}

std::optional<UsbRefusal> Falcon::start(UsbPort& port, UsbBus& bus) {
  reader_ = {};
  position_ = DeltaKinematics::kCentre;
  if (auto refused = bootFalcon(port, bus, firmware_)) return refused;
  if (homeAnew_) sendAgain(port, bus, encode(FalconCommand{}), kForgetCommands);
  homeAnew_ = false;
  return std::nullopt;
}

bool Falcon::take(std::span<const std::uint8_t> bytes, const std::function<void(const DeviceReply&)>& found) {
  const std::uint64_t skippedBefore = reader_.skippedBytes();
  for (std::size_t i = kModemStatus_bytes; i < bytes.size(); ++i) {
    if (const auto reply = reader_.take(bytes[i])) found(*reply);
  }
  return reader_.skippedBytes() != skippedBefore;
}

std::optional<Vec3> Falcon::locate(const DeviceReply& reply) {
  std::array<std::int16_t, 3> counts = reply.counts;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (sense_[static_cast<int>(i)] < 0) counts[i] = static_cast<std::int16_t>(-std::max<int>(counts[i], -32'767));
  }
  const auto position = DeltaKinematics::positionAt(falconAngles(counts), position_);
  if (position) position_ = *position;
  return position;
}

std::span<const std::uint8_t> Falcon::command(Vec3 force_N, DeviceLight light) {
  // The motors' numbers count against the angles.
  const Vec3 units = DeltaKinematics::torquesFor(forceScale_ * force_N, position_) * -motorUnitsPerNm_ * sense_;
  FalconCommand command{.motors = motorNumbers(units, kMotorLimit), .homing = true};
  command.green = light == DeviceLight::kReady;
  command.blue = light == DeviceLight::kHoming;
  command.red = light == DeviceLight::kFault;
  frame_ = encode(command);
  return frame_;
}

}  // namespace haptics

#include "haptic_server/device/usb/wooden_haptics.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "common/maths/rotation.h"
#include "haptic_server/device/usb/arm_kinematics.h"

namespace haptics {
namespace {

constexpr double kCountsPerTurn = 2'000;
/// Capstan to body: how far a body turns as its motor turns once.
constexpr Vec3 kGear{0.010 / 0.160, 0.010 / 0.120, 0.010 / 0.120};
/// Sense of each body's angle against its motor's.
constexpr Vec3 kSense{1, -1, -1};
constexpr Vec3 kWoodenCount_rad = 2 * std::numbers::pi / kCountsPerTurn * kGear * kSense;
// Dynamics of the arm at its handle: not published, assumed from its size.
constexpr double kAssumedMass_kg = 0.2, kAssumedViscous_Ns_per_m = 0.1, kAssumedCoulomb_N = 0.1;
constexpr std::uint64_t kFirstReport_ns = 500'000'000;
/// The device's x comes towards the user, its y to the user's right.
const Quat kWoodenUpright = rotationBy(Vec3(0, 0, -std::numbers::pi / 2));
constexpr Vec3 kCentre{0};  // middle of the workspace in the device's frame, which has its origin there

[[nodiscard]] std::int16_t numberAt(std::span<const std::uint8_t> bytes, std::size_t index) noexcept {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(bytes[2 * index] | bytes[2 * index + 1] << 8));
}

[[nodiscard]] DeviceInfo describeWooden(const DeviceCalibration& calibration, double scale) {
  using W = WoodenHaptics;
  constexpr double kResolution_m = 2 * std::numbers::pi / kCountsPerTurn * kGear.y * ArmKinematics::kForearm_m;
  return {.name = "WoodenHaptics 1.5",
          .maxForce_N = std::min(W::kMaxForce_N, calibration.maxForce_N.value_or(W::kMaxForce_N)),
          .maxStiffness_N_per_m = W::kMaxStiffness_N_per_m / scale,
          .maxDamping_Ns_per_m = W::kMaxDamping_Ns_per_m / scale,
          .resolution_m = kResolution_m * scale,
          .apparentMass_kg = kAssumedMass_kg / scale,
          .viscousFriction_Ns_per_m = kAssumedViscous_Ns_per_m / scale,
          .coulombFriction_N = kAssumedCoulomb_N,
          .delay_s = kExchangeDelay_s};
}

}  // namespace

Vec3 woodenAngles(Vec3 counts) noexcept { return ArmKinematics::kRestAngles + kWoodenCount_rad * counts; }
Vec3 woodenCounts(Vec3 angles) noexcept { return (angles - ArmKinematics::kRestAngles) / kWoodenCount_rad; }

WoodenHaptics::WoodenHaptics(const DeviceCalibration& calibration)
    : forceScale_(calibration.forceScale.value_or(1)),
      sense_(calibration.sense()),
      placement_(calibration, kWoodenUpright, kCentre),
      info_(describeWooden(calibration, placement_.scale())),
      angles_(ArmKinematics::kRestAngles) {}

std::optional<UsbRefusal> WoodenHaptics::start(UsbPort& port, UsbBus& bus) {
  resting_ = 0;
  homed_ = false;
  angles_ = ArmKinematics::kRestAngles;
  const std::uint64_t deadline_ns = bus.clock_ns() + kFirstReport_ns;
  for (;;) {
    if (port.send(command(Vec3(0), DeviceLight::kOff)) == UsbOutcome::kGone) break;
    const UsbArrival arrival = port.next(deadline_ns);
    if (arrival.kind == UsbArrival::Kind::kGone) break;
    if (arrival.kind != UsbArrival::Kind::kBytes) {
      return UsbRefusal{DeviceFault::kNotAnswering,
                        {info_.name, "sends no reports; is it the firmware with reports of 8 bytes?"}};
    }
    if (arrival.bytes.size() == report_.size()) return std::nullopt;
  }
  return UsbRefusal{DeviceFault::kUnplugged, {info_.name, "went away"}};
}

bool WoodenHaptics::take(std::span<const std::uint8_t> bytes, const std::function<void(const DeviceReply&)>& found) {
  if (bytes.size() != report_.size()) return true;
  DeviceReply reply{.counts = {numberAt(bytes, 0), numberAt(bytes, 1), numberAt(bytes, 2)}};
  if (!homed_) watchRest(reply.counts);
  if (homed_) reply.homedAxes = kAllAxes;
  found(reply);
  return false;
}

void WoodenHaptics::watchRest(const std::array<std::int16_t, 3>& counts) noexcept {
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (std::abs(counts[i] - rest_[i]) > kRestingCounts) resting_ = 0;
  }
  if (resting_ == 0) rest_ = counts;
  homed_ = ++resting_ >= kRestingReports;
}

std::optional<Vec3> WoodenHaptics::locate(const DeviceReply& reply) {
  const auto& [a, b, c] = reply.counts;
  angles_ = woodenAngles(homed_ ? sense_ * Vec3(a - rest_[0], b - rest_[1], c - rest_[2]) : Vec3(0));
  return ArmKinematics::positionAt(angles_);
}

std::span<const std::uint8_t> WoodenHaptics::command(Vec3 force_N, DeviceLight) {
  Vec3 torques(0);
  if (!ArmKinematics::nearSingular(angles_)) torques = ArmKinematics::torquesFor(forceScale_ * force_N, angles_);
  const auto milliamperes =
      motorNumbers(torques * kGear * kSense * (1e3 / kTorqueConstant_Nm_per_A) * sense_, kMaxCurrent_mA);
  for (std::size_t i = 0; i < milliamperes.size(); ++i) {
    const auto number = static_cast<std::uint16_t>(milliamperes[i]);
    report_[2 * i] = static_cast<std::uint8_t>(number & 0xFF);
    report_[2 * i + 1] = static_cast<std::uint8_t>(number >> 8);
  }
  return report_;
}

}  // namespace haptics

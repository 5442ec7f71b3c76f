#include "tests/haptic_server/device/emulated/wooden_model.h"

#include <algorithm>
#include <cmath>

#include "haptic_server/device/usb/arm_kinematics.h"
#include "haptic_server/device/usb/wooden_haptics.h"

namespace haptics::test {
namespace {

using K = ArmKinematics;

constexpr std::uint64_t kFrame_ns = 1'000'000;  // of the bus
constexpr std::uint64_t kSlowFrame_ns = 12'000'000;
constexpr std::uint64_t kQuiet_ns = 100'000'000, kRest_ns = 2'000'000'000;
constexpr double kLifting_s = 0.5;  // from the rest pose into the workspace

// Upright: x right, y away from the user, z up. The device's own: x towards the user, y right, z up.
Vec3 toDevice(Vec3 upright) { return {-upright.y, upright.x, upright.z}; }
Vec3 toUpright(Vec3 vector) { return {vector.y, -vector.x, vector.z}; }

DevicePreset mechanicsOfTheArm() {
  return {.name = "wooden",
          .title = "WoodenHaptics",
          .maxForce_N = 5,
          .maxStiffness_N_per_m = 1000,
          .maxDamping_Ns_per_m = 8,
          .apparentMass_kg = 0.2,
          .viscousFriction_Ns_per_m = 0.1,
          .coulombFriction_N = 0.1,
          .resolution_m = 64e-6};
}

}  // namespace

WoodenModel::WoodenModel() : mechanics_(mechanicsOfTheArm()) {}

std::vector<std::uint8_t> WoodenModel::descriptors() const {
  return {18, 1,    0x00, 0x02, 0, 0, 0,    64,   0x34, 0x12, 0x06, 0x00, 0x00, 0x01, 1, 2, 3, 1,  // 1234:0006
          9,  2,    41,   0,    1, 1, 0,    0x80, 50,                                              //
          9,  4,    0,    0,    2, 3, 0,    0,    0,                                               // HID
          9,  0x21, 0x11, 0x01, 0, 1, 0x22, 33,   0,                                               //
          7,  5,    0x81, 3,    8, 0, 1,                                                           // interrupt IN
          7,  5,    0x01, 3,    8, 0, 1};                                                          // interrupt OUT
}

std::string WoodenModel::stringDescriptor(int index) const {
  return index == 1 ? "WoodenHaptics" : index == 2 ? "WoodenHaptics 1.5 (emulated)" : index == 3 ? "WOOD0001" : "";
}

void WoodenModel::powerCycle() {
  held_ = halted_ = false;
  taken_ = 0;
  motors_ = {};
  motor_N_ = Vec3(0);
}

void WoodenModel::setFault(EmulatedFault fault, std::uint64_t) {
  fault_ = fault;
  halted_ = fault == EmulatedFault::kStall;
  jump_ = fault == EmulatedFault::kJump ? 300 : fault == EmulatedFault::kGlitch ? 65 : 0;
}

int WoodenModel::control(std::uint8_t, std::uint8_t, std::uint16_t, std::uint64_t) { return -EPIPE; }

Vec3 WoodenModel::angles() const {
  // The workspace in front of the arm, a bit below its rest pose.
  const auto there = K::anglesAt(toDevice(mechanics_.position()));
  return glm::mix(K::kRestAngles, there.value_or(K::kRestAngles), taken_);
}

std::array<std::int16_t, 3> WoodenModel::counts() const {
  const Vec3 exact = woodenCounts(angles());
  return {static_cast<std::int16_t>(std::lround(exact.x)), static_cast<std::int16_t>(std::lround(exact.y) + jump_),
          static_cast<std::int16_t>(std::lround(exact.z))};
}

int WoodenModel::out(std::span<const std::uint8_t> bytes, std::uint64_t now_ns) {
  advance(now_ns);
  lastOut_ns_ = now_ns;
  if (bytes.size() != 8) return static_cast<int>(bytes.size());
  for (std::size_t i = 0; i < 3; ++i) {
    motors_[i] = static_cast<std::int16_t>(static_cast<std::uint16_t>(bytes[2 * i] | bytes[2 * i + 1] << 8));
  }
  const Vec3 amperes = Vec3(motors_[0], motors_[1], motors_[2]) * 1e-3;
  // Capstans: 10 mm on 160, 120 and 120 mm; b and c turn against their motors.
  const Vec3 torque = amperes * WoodenHaptics::kTorqueConstant_Nm_per_A * Vec3(16, -12, -12);
  const glm::dmat3 jacobian = K::positionByAngles(angles());
  motor_N_ = toUpright(glm::inverse(glm::transpose(jacobian)) * torque);
  return static_cast<int>(bytes.size());
}

std::optional<std::uint64_t> WoodenModel::inReadyAt(std::uint64_t posted_ns) const {
  if (halted_) return posted_ns;
  if (fault_ == EmulatedFault::kSilence) return std::nullopt;
  return std::max(posted_ns, lastIn_ns_ + (fault_ == EmulatedFault::kSlow ? kSlowFrame_ns : kFrame_ns));
}

int WoodenModel::in(std::span<std::uint8_t> bytes, std::uint64_t now_ns) {
  advance(now_ns);
  // On the bus's own beat, as far as somebody asks in time.
  const std::uint64_t beat_ns = lastIn_ns_ + kFrame_ns;
  lastIn_ns_ = now_ns - beat_ns < kFrame_ns ? beat_ns : now_ns;
  if (halted_) return -EPIPE;
  const auto at = counts();
  std::array<std::uint8_t, 8> report{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto number = static_cast<std::uint16_t>(at[i]);
    report[2 * i] = static_cast<std::uint8_t>(number & 0xFF);
    report[2 * i + 1] = static_cast<std::uint8_t>(number >> 8);
  }
  ++reports_;
  std::size_t length = report.size();
  if (fault_ == EmulatedFault::kShort) length = 5;
  if (fault_ == EmulatedFault::kShifted) std::ranges::rotate(report, report.begin() + 3);
  length = std::min(length, bytes.size());
  std::copy_n(report.begin(), length, bytes.begin());
  return static_cast<int>(length);
}

void WoodenModel::advance(std::uint64_t now_ns) {
  if (now_ns - lastOut_ns_ > kQuiet_ns) talkSince_ns_ = now_ns;
  held_ = now_ns - talkSince_ns_ > kRest_ns;
  if (lastAdvance_ns_ != 0) {
    const double way = static_cast<double>(now_ns - lastAdvance_ns_) * 1e-9 / kLifting_s;
    taken_ = std::clamp(taken_ + (held_ ? way : -way), 0.0, 1.0);
  }
  lastAdvance_ns_ = now_ns;
  if (now_ns > lastOut_ns_ + kWatchdog_ns) {
    motors_ = {};
    motor_N_ = Vec3(0);
  }
  mechanics_.advance(now_ns, motor_N_);
}

}  // namespace haptics::test

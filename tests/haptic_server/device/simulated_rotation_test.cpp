#include "haptic_server/device/simulated_rotation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/maths/rotation.h"
#include "haptic_server/device/simulated_device.h"

namespace haptics::simulated_rotation_test {
namespace {

constexpr double kPeriod_s = 1e-3;

/// Without friction.
DevicePreset frictionless() {
  DevicePreset preset = findDevicePreset("sigma.7").value();
  preset.rotation.viscousFriction_Nms_per_rad = preset.rotation.coulombFriction_Nm = 0;
  return preset;
}

class StillHand final : public HandIntent {
 public:
  HandTarget next(double /*dt_s*/, Vec3 /*felt_N*/) noexcept override { return {}; }
  Quat nextRotation(double /*dt_s*/) noexcept override { return wanted; }
  Quat wanted{1, 0, 0, 0};
};

TEST(SimulatedRotation, TurnsAsAFreeBodyUnderATorque) {
  StillHand hand;
  const DevicePreset preset = frictionless();
  SimulatedDevice device({preset, findHandPreset("none").value(), kPeriod_s}, hand);
  (void)device.read(0);
  const Vec3 torque_Nm(0.003, -0.002, 0.001);
  for (std::uint64_t tick = 1; tick <= 500; ++tick) {
    device.writeTorque(torque_Nm);
    device.write(Vec3(0));
    (void)device.read(tick);
  }
  const double seconds = 0.5;
  const Vec3 angle = torque_Nm * (seconds * seconds / 2 / preset.rotation.inertia_kgm2);
  EXPECT_NEAR(glm::length(rotationVector(device.rotation() * glm::conjugate(rotationBy(angle)))), 0, 1e-6);
}

TEST(SimulatedRotation, SwingsInAHandAtItsFrequency) {
  StillHand hand;
  const DevicePreset preset = frictionless();
  HandPreset loose = findHandPreset("light").value();
  loose.damping_Ns_per_m = 0;
  SimulatedDevice device({preset, loose, kPeriod_s}, hand);
  (void)device.read(0);
  hand.wanted = rotationBy({0.1, 0, 0});  // a step: it swings about there
  const double lever = kUsualGyration_m * kUsualGyration_m;
  const double inertia = preset.rotation.inertia_kgm2 + loose.mass_kg * lever;
  const double period_s = 2 * std::numbers::pi * std::sqrt(inertia / (loose.stiffness_N_per_m * lever));
  const auto ticks = static_cast<std::uint64_t>(std::lround(10 * period_s / kPeriod_s));
  for (std::uint64_t tick = 1; tick <= ticks; ++tick) (void)device.read(tick);
  EXPECT_NEAR(rotationVector(device.rotation()).x, 0, 2e-3) << "back where it began after ten swings";
  EXPECT_EQ(rotationVector(device.rotation()).y, 0);
}

TEST(SimulatedRotation, IsToldInStepsOfTheEncoderAndTorqueEndsAtTheLimit) {
  StillHand hand;
  hand.wanted = rotationBy({0.2, 0.1, -0.3});
  const DevicePreset preset = findDevicePreset("sigma.7").value();
  SimulatedDevice device({preset, findHandPreset("none").value(), kPeriod_s}, hand);
  const Vec3 told = rotationVector(device.read(0).rotation) / preset.rotation.resolution_rad;
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(told[axis], std::round(told[axis]), 1e-9);
  SimulatedDevice other({preset, findHandPreset("none").value(), kPeriod_s}, hand);
  (void)other.read(0);
  for (std::uint64_t tick = 1; tick <= 50; ++tick) {
    device.writeTorque({0, 0, preset.rotation.maxTorque_Nm});
    other.writeTorque({0, 0, 100});
    device.write(Vec3(0));
    other.write(Vec3(0));
    EXPECT_EQ(device.read(tick).rotation, other.read(tick).rotation);
  }
  device.stop();
  device.writeTorque({0, 0, 100});
  other.writeTorque({0, 0, std::nan("")});
  device.write(Vec3(0));
  other.write(Vec3(0));
  EXPECT_EQ(device.read(60).rotation, other.read(60).rotation);
}

TEST(SimulatedRotation, OneThatSensesNoneStaysUpright) {
  StillHand hand;
  hand.wanted = rotationBy({0.2, 0, 0});
  SimulatedDevice device({findDevicePreset("omni").value(), findHandPreset("nominal").value(), kPeriod_s}, hand);
  device.writeTorque({1, 0, 0});
  EXPECT_EQ(device.read(0).rotation, Quat(1, 0, 0, 0));
  EXPECT_EQ(device.read(10).rotation, Quat(1, 0, 0, 0));
}

TEST(SimulatedRotation, IsATranslationOnItsRadius) {
  DeviceInfo device;
  device.apparentMass_kg = 0.2;
  device.rotation = {true, 0.3, 2, 1e-3, 0.2 * 0.04 * 0.04, 1e-3, 2e-3};
  EXPECT_NEAR(gyration_m(device), 0.04, 1e-12);
  const DeviceInfo moved = rotationAsTranslation(device);
  EXPECT_NEAR(moved.apparentMass_kg, 0.2, 1e-12);
  EXPECT_NEAR(moved.maxForce_N, 0.3 / 0.04, 1e-12);
  EXPECT_NEAR(moved.maxStiffness_N_per_m, 2 / 0.0016, 1e-9);
  EXPECT_NEAR(moved.resolution_m, 4e-5, 1e-12);
}

}  // namespace
}  // namespace haptics::simulated_rotation_test

#include "haptic_server/device/usb/falcon.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "haptic_server/device/usb/delta_kinematics.h"
#include "haptic_server/device/usb/wooden_haptics.h"

namespace haptics::test::falcon_test {
namespace {

/// Motor numbers in a Falcon's command.
Vec3 motorsOf(std::span<const std::uint8_t> frame) {
  Vec3 motors;
  for (int axis = 0; axis < 3; ++axis) {
    unsigned number = 0;
    for (int digit = 0; digit < 4; ++digit) {
      number |= static_cast<unsigned>(frame[static_cast<std::size_t>(1 + 4 * axis + digit)] - 'A') << (4 * digit);
    }
    motors[axis] = static_cast<std::int16_t>(static_cast<std::uint16_t>(number));
  }
  return motors;
}

TEST(Placement, PutsAFalconsMiddleInTheWorldWithItsUserInFrontAndComesBack) {
  const Falcon falcon({}, std::nullopt);
  const Placement& placement = falcon.placement();
  const Vec3 middle = DeltaKinematics::kCentre;
  EXPECT_LT(glm::distance(placement.toWorld(middle), Vec3(0, 0, 0.05)), 1e-12);
  EXPECT_LT(glm::distance(placement.toWorld(middle + Vec3(0, 0, 0.01)), Vec3(0, -0.01, 0.05)), 1e-12)
      << "out is to the user";
  EXPECT_LT(glm::distance(placement.toWorld(middle + Vec3(0, 0.01, 0)), Vec3(0, 0, 0.06)), 1e-12) << "up is up";
  const Vec3 somewhere(0.01, 0.02, 0.03);
  EXPECT_LT(glm::distance(placement.toDevice(placement.toWorld(somewhere)), somewhere), 1e-12);
  EXPECT_LT(glm::distance(placement.forceToDevice({0, 0, 1}), Vec3(0, 1, 0)), 1e-12);
}

TEST(Placement, OfAnArmHasItsUserInFrontToo) {
  const WoodenHaptics arm(DeviceCalibration{});
  EXPECT_LT(glm::distance(arm.placement().toWorld({0.01, 0, 0}), Vec3(0, -0.01, 0.05)), 1e-12);
  EXPECT_LT(glm::distance(arm.placement().toWorld({0, 0.01, 0}), Vec3(0.01, 0, 0.05)), 1e-12);
}

TEST(Falcon, AScaledWorkspaceScalesWhatTheServoMayRender) {
  const Falcon plain({}, std::nullopt);
  const Falcon scaled(DeviceCalibration{.workspaceScale = 2, .maxForce_N = 3}, std::nullopt);
  EXPECT_DOUBLE_EQ(scaled.info().maxStiffness_N_per_m, plain.info().maxStiffness_N_per_m / 2);
  EXPECT_DOUBLE_EQ(scaled.info().resolution_m, plain.info().resolution_m * 2);
  EXPECT_DOUBLE_EQ(scaled.info().maxForce_N, 3);
  EXPECT_DOUBLE_EQ(Falcon(DeviceCalibration{.maxForce_N = 1000}, std::nullopt).info().maxForce_N,
                   plain.info().maxForce_N);
}

TEST(Falcon, PushesThroughMotorsThatCountAgainstTheAngles) {
  Falcon falcon({}, std::nullopt);
  ASSERT_TRUE(falcon.locate({.counts = {0, 0, 0}, .homedAxes = 7}));
  const Vec3 motors = motorsOf(falcon.command({0, 0, 2}, DeviceLight::kReady));
  EXPECT_LT(std::max({motors.x, motors.y, motors.z}), 0) << "angles grow as the grip comes out";
  EXPECT_NEAR(motors.x, motors.y, 1);
  EXPECT_NEAR(motors.y, motors.z, 1);
}

TEST(Falcon, ShortensAForceThatIsTooLargeWithoutTurningIt) {
  Falcon falcon({}, std::nullopt);
  ASSERT_TRUE(falcon.locate({.counts = {100, -50, 20}, .homedAxes = 7}));
  const Vec3 some = motorsOf(falcon.command({1, 2, -1}, DeviceLight::kReady));
  const Vec3 most = motorsOf(falcon.command({1000, 2000, -1000}, DeviceLight::kReady));
  EXPECT_EQ(std::max({std::abs(most.x), std::abs(most.y), std::abs(most.z)}), Falcon::kMotorLimit);
  EXPECT_LT(glm::distance(glm::normalize(some), glm::normalize(most)), 5e-3);
  EXPECT_EQ(motorsOf(falcon.command({std::nan(""), 0, 0}, DeviceLight::kReady)), Vec3(0));
}

TEST(Falcon, CalibrationTurnsAxesRoundAndWeakensTheMotors) {
  Falcon plain({}, std::nullopt);
  Falcon turned(DeviceCalibration{.forceScale = 0.5, .reversed = {false, true, false}}, std::nullopt);
  ASSERT_TRUE(plain.locate({.counts = {100, -50, 20}}));
  ASSERT_TRUE(turned.locate({.counts = {100, 50, 20}}));
  const Vec3 a = motorsOf(plain.command({1, 2, -1}, DeviceLight::kReady));
  const Vec3 b = motorsOf(turned.command({1, 2, -1}, DeviceLight::kReady));
  EXPECT_NEAR(b.x, a.x / 2, 1);
  EXPECT_NEAR(b.y, -a.y / 2, 1);
  EXPECT_NEAR(b.z, a.z / 2, 1);
}

TEST(Falcon, CountsThatNoPoseHasHaveNoPlaceAndTheLastGoodOneStays) {
  Falcon falcon({}, std::nullopt);
  ASSERT_TRUE(falcon.locate({.counts = {100, -50, 20}}));
  EXPECT_FALSE(falcon.locate({.counts = {32767, -32768, 0}}));
  const auto again = falcon.locate({.counts = {100, -50, 20}});
  ASSERT_TRUE(again);
}

TEST(WoodenHaptics, AnArmThatTremblesIsNotAtRest) {
  WoodenHaptics arm(DeviceCalibration{});
  int reports = 0;
  bool homed = false;
  const auto report = [&](std::uint8_t counts) {
    const std::array<std::uint8_t, 8> bytes{counts};
    EXPECT_FALSE(arm.take(bytes, [&](const DeviceReply& reply) { homed = reply.homedAxes == kAllAxes; }));
    ++reports;
  };
  for (int i = 0; i < 5 * WoodenHaptics::kRestingReports; ++i) report(i % 100 < 50 ? 0 : 10);
  EXPECT_FALSE(homed);
  for (int i = 0; i < WoodenHaptics::kRestingReports; ++i) report(10);
  EXPECT_TRUE(homed);
}

TEST(WoodenHaptics, AReportOfAnotherLengthIsNone) {
  WoodenHaptics arm(DeviceCalibration{});
  const std::array<std::uint8_t, 9> bytes{};
  for (std::size_t length : {0U, 1U, 7U, 9U}) {
    EXPECT_TRUE(arm.take(std::span(bytes).first(length), [](const DeviceReply&) { FAIL(); })) << length;
  }
}

}  // namespace
}  // namespace haptics::test::falcon_test

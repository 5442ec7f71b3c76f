#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "common/mesh/generators.h"
#include "haptic_server/engine/step/haptic_step.h"
#include "haptic_server/servo/allocation_tripwire.h"
#include "tests/haptic_server/engine/step/virtual_servo.h"

namespace haptics::haptic_step_tests {
namespace {

using namespace fixture;

constexpr StepConfig kConfig{.period_s = 1e-3, .maxForce_N = 3.3};

/// A box of 100 mm whose upper side is the plane z = 0.
ServoObject slab(std::uint64_t id = 1) {
  return objectOf(id, surfaceOf(makeBox(Vec3(0.1), 4).value()), Vec3(0, 0, -0.05));
}

/// Comes down at 50 mm/s from 5 mm above the slab to 2 mm inside it and stays.
Vec3 pressDown(std::uint64_t tick) { return {0.01, 0.012, std::max(0.005 - 5e-5 * static_cast<double>(tick), -0.002)}; }

TEST(HapticStep, GivesHookesLawOnAHeldSurface) {
  VirtualServo servo(pressDown, kConfig, sceneOf(1, {slab()}));
  const TelemetrySample sample = servo.run(1000);
  EXPECT_EQ(sample.object, 1U);
  EXPECT_EQ(sample.sceneRevision, 1U);
  EXPECT_NEAR(sample.penetration_m, 0.002, 1e-9);
  EXPECT_NEAR(sample.force.written.z, 800 * 0.002, 1e-6);
  EXPECT_NEAR(sample.ihip.z, 0, 1e-9);
  EXPECT_NEAR(sample.surfaceNormal.z, 1, 1e-9);
}

TEST(HapticStep, FeelsTheSurfaceInTheVeryTickOfFirstContact) {
  VirtualServo servo(pressDown, kConfig, sceneOf(1, {slab()}));
  for (int i = 0; i < 200; ++i) {
    const TelemetrySample sample = servo.step();
    if (sample.hip.z < -1e-9) {
      EXPECT_GT(sample.force.written.z, 0);
      return;
    }
    if (sample.hip.z > 1e-9) {
      EXPECT_EQ(sample.force.written, Vec3(0));
    }
  }
  FAIL() << "never inside";
}

TEST(HapticStep, NeverWritesMoreThanTheDeviceTakes) {
  VirtualServo servo([](std::uint64_t tick) { return Vec3(0.01, 0.012, 0.005 - 5e-5 * static_cast<double>(tick)); },
                     kConfig, sceneOf(1, {slab()}));
  const TelemetrySample sample = servo.run(500);
  EXPECT_GT(glm::length(sample.force.contact), 10);
  EXPECT_NEAR(glm::length(sample.force.written), kConfig.maxForce_N, 1e-9);
}

TEST(HapticStep, TakesTheForceAwayOnAnImpossibleReadingAndComesBackWithoutAKick) {
  for (const double impossible : {std::numeric_limits<double>::quiet_NaN(), 1e5, -1e87}) {
    VirtualServo servo(pressDown, kConfig, sceneOf(1, {slab()}));
    servo.run(500);
    double last = 1.6;
    for (int i = 0; i < 40; ++i) {
      const auto sample = servo.stepAt(Vec3(impossible, 0, 0), DeviceState::kReady);
      ASSERT_EQ(sample.fault, Fault::kNonFiniteInput) << impossible;
      EXPECT_LE(sample.force.written.z, last);
      EXPECT_GE(sample.force.written.z, last - 1.7 / 20);
      last = sample.force.written.z;
    }
    EXPECT_NEAR(last, 0, 1e-12);
    const TelemetrySample back = servo.run(100);
    EXPECT_EQ(back.fault, Fault::kNone);
    EXPECT_EQ(back.force.written, Vec3(0)) << "inside the slab after a fault: no force until a surface is met anew";
  }
}

TEST(HapticStep, FinishesTheRampOfAFaultThatLastsOneTick) {
  VirtualServo servo(pressDown, kConfig, sceneOf(1, {slab()}));
  servo.run(500);
  (void)servo.stepAt(Vec3(std::numeric_limits<double>::infinity()), DeviceState::kReady);
  double last = 1.6;
  for (int i = 0; i < 40; ++i) {
    const double force = servo.step().force.written.z;
    EXPECT_GE(force, last - 2 * 1.7 / 20);
    last = force;
  }
  EXPECT_NEAR(last, 0, 1e-12);
}

TEST(HapticStep, TakesTheForceAwayAfterTooManyMissedTicksInARowAndComesBack) {
  VirtualServo servo(pressDown, kConfig, sceneOf(1, {slab()}));
  servo.run(500);
  servo.skip(30);
  EXPECT_EQ(servo.step().fault, Fault::kNone);
  servo.run(10);
  servo.skip(60);
  const TelemetrySample first = servo.step();
  EXPECT_EQ(first.fault, Fault::kDeadlinesMissed);
  EXPECT_LT(first.force.written.z, 1.6);
  EXPECT_NEAR(servo.run(29).force.written.z, 0, 1e-12);
  EXPECT_EQ(servo.run(2).fault, Fault::kNone);
}

TEST(HapticStep, KeepsTheForceAwayWhereMissedTicksTakeItAwayAgainAndAgain) {
  VirtualServo servo(pressDown, kConfig, sceneOf(1, {slab()}));
  servo.run(500);
  const auto takeAway = [&] {
    servo.skip(60);
    return servo.step();
  };
  EXPECT_EQ(takeAway().wait_s, 0);
  EXPECT_EQ(servo.run(40).fault, Fault::kNone);
  const TelemetrySample second = takeAway();
  EXPECT_EQ(second.fault, Fault::kDeadlinesMissed);
  EXPECT_NEAR(second.wait_s, 2, 0.002);
  for (int i = 0; i < 5; ++i) EXPECT_LE(takeAway().wait_s, 2) << "the same fault goes on";
  const TelemetrySample late = servo.run(1600);
  EXPECT_EQ(late.fault, Fault::kDeadlinesMissed);
  EXPECT_NEAR(late.force.written.z, 0, 1e-12);
  EXPECT_EQ(servo.run(500).fault, Fault::kNone);
}

TEST(HapticStep, LetsTheForceComeSlowlyAfterAttach) {
  StepConfig config = kConfig;
  config.rise_s = 0.4;
  VirtualServo servo(pressDown, config, sceneOf(1, {slab()}));
  servo.run(199);  // begins at tick 0; on the way in
  const TelemetrySample half = servo.step();
  EXPECT_NEAR(half.force.written.z, half.force.contact.z / 2, 1e-6);
  const TelemetrySample whole = servo.run(300);
  EXPECT_NEAR(whole.force.written.z, 800 * 0.002, 1e-6);
}

TEST(HapticStep, WritesNoForceThroughADeviceThatReportsAFaultOrIsNotHomed) {
  VirtualServo servo(pressDown, kConfig, sceneOf(1, {slab()}));
  servo.run(500);
  DeviceReading reading{pressDown(500), DeviceState::kReady, {}};
  reading.status.fault = DeviceFault::kGarbled;
  EXPECT_EQ(servo.stepWith(reading).fault, Fault::kDeviceLost);
  for (int i = 0; i < 40; ++i) (void)servo.stepWith(reading);
  EXPECT_EQ(servo.step().fault, Fault::kNone);
  reading.status = {};
  reading.status.homed = false;
  EXPECT_EQ(servo.stepWith(reading).fault, Fault::kDeviceLost);
}

TEST(HapticStep, TreatsALostDeviceAsAFault) {
  VirtualServo servo(pressDown, kConfig, sceneOf(1, {slab()}));
  servo.run(500);
  TelemetrySample sample;
  for (int i = 0; i < 31; ++i) sample = servo.stepAt(pressDown(1000), DeviceState::kAbsent);
  EXPECT_EQ(sample.fault, Fault::kDeviceLost);
  EXPECT_EQ(sample.force.written, Vec3(0));
}

TEST(HapticStep, TakesTheForceAwayWhenThePositionIsOlderThanFiveMilliseconds) {
  VirtualServo servo(pressDown, kConfig, sceneOf(1, {slab()}));
  servo.run(500);
  const auto aged = [&](std::uint32_t age_us) {
    return servo.stepWith({pressDown(1000), DeviceState::kReady, {.age_us = age_us}});
  };
  EXPECT_EQ(aged(5'000).fault, Fault::kNone);
  TelemetrySample sample;
  for (int i = 0; i < 31; ++i) sample = aged(5'001);
  EXPECT_EQ(sample.fault, Fault::kDeviceStale);
  EXPECT_EQ(sample.device.age_us, 5'001U);
  EXPECT_EQ(sample.force.written, Vec3(0));
}

TEST(HapticStep, GoesOnBitForBitFromACopyOfItsState) {
  const auto circle = [](std::uint64_t tick) {
    const double angle = 0.003 * static_cast<double>(tick);
    return Vec3(0.03 * std::cos(angle), 0.03 * std::sin(angle), -0.002 + 0.003 * std::cos(7 * angle));
  };
  VirtualServo servo(circle, kConfig, sceneOf(1, {slab()}));
  servo.run(777);
  VirtualServo copy = servo;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 a = servo.step().force.written, b = copy.step().force.written;
    ASSERT_EQ(std::memcmp(&a, &b, sizeof a), 0) << i;
  }
}

TEST(HapticStep, AllocatesNothing) {
  VirtualServo servo(pressDown, kConfig);
  const std::shared_ptr<const ServoScene> first = sceneOf(1, {slab()}), second = sceneOf(2, {slab(), slab(2)});
  servo.adopt(first);
  const std::uint64_t before = AllocationTripwire::count();
  {
    const AllocationTripwire armed;
    servo.run(300);
  }
  EXPECT_EQ(AllocationTripwire::count(), before);
  {
    const AllocationTripwire armed;
    ::operator delete(::operator new(8));
  }
  EXPECT_GT(AllocationTripwire::count(), before) << "the tripwire itself must work";
}

TEST(HapticStep, SaysSinceWhenARevisionIsFeltAlsoWhenItIsPublishedAgain) {
  VirtualServo servo(pressDown, kConfig);
  servo.run(3);
  servo.adopt(sceneOf(1, {slab()}));
  servo.run(10);
  servo.adopt(sceneOf(1, {slab()}));
  EXPECT_EQ(servo.step().adoptionTick, 3U);
  servo.adopt(sceneOf(2, {slab()}));
  EXPECT_EQ(servo.step().adoptionTick, 14U);
}

TEST(HapticStep, AccountsTheWorkOfThePress) {
  VirtualServo servo(pressDown, kConfig, sceneOf(1, {slab()}));
  const TelemetrySample sample = servo.run(1000);
  // The hand put 1/2 k p^2 into the spring, less what the hold of each force over a tick misses, plus the damper.
  EXPECT_NEAR(sample.energyGiven_J[0], -0.5 * 800 * 0.002 * 0.002, 0.2e-3);
  EXPECT_LT(sample.energyGiven_J[0], 0);
}

}  // namespace
}  // namespace haptics::haptic_step_tests

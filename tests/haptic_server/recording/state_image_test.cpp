#include "haptic_server/recording/state_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "recorded_servo.h"

namespace haptics::state_image_test {
namespace {

using namespace test;

/// @return In how many of the rounds some dent was there.
int goesOnBitForBit(const std::string& scene) {
  RecordedServo servo(scene);
  int dented = 0;
  for (int round = 0; round < 40; ++round) {
    servo.runTurning(97);
    auto state = stateFrom(stateImage(servo.state()), servo.scene(), servo.config());
    EXPECT_TRUE(state) << state.error().text();
    if (!state) return dented;
    HapticState original = servo.state();
    dented += original.dents.count > 0 ? 1 : 0;
    for (int i = 0; i < 50; ++i) {
      const StepInput input{
          1, 0, {Vec3(0.001 * i - 0.05, 0, -0.001), DeviceState::kReady, {}, rotationBy({0, 0.004 * i, 0})}};
      const Vec3 expected = hapticStep(servo.scene(), original, servo.config(), input).force.written;
      EXPECT_EQ(hapticStep(servo.scene(), **state, servo.config(), input).force.written, expected);
      EXPECT_EQ(writtenTorque_Nm(**state), writtenTorque_Nm(original));
    }
  }
  return dented;
}

TEST(StateImage, GivesAStateThatGoesOnBitForBit) { goesOnBitForBit(kScene + kBlock); }

TEST(StateImage, GivesAStateWithAToolThatGoesOnBitForBit) { goesOnBitForBit(kScene + kBlock + kTool); }

TEST(StateImage, GivesAStateWithDentsThatGoesOnBitForBit) { EXPECT_GT(goesOnBitForBit(kScene + kCushion), 5); }

/// What holds a dent up is put there and taken away again, at any moment of a press.
TEST(StateImage, GoesOnBitForBitFromEveryTickAcrossEditsBelowADent) {
  RecordedServo servo(kScene + kCushion);
  servo.computeTwice();
  int held = 0;
  for (int i = 0; i < 60; ++i) {
    const std::string z = i % 2 == 0 ? "0.04" : "0.01";
    servo.apply(R"(operations { remesh { object { name: "slab" } mesh { box { size_m { x: 0.2 y: 0.2 z: )" + z +
                " } } } } }");
    for (int tick = 0; tick < 100; ++tick) {
      const double phase = 2 * std::numbers::pi * (100 * i + tick) / 430;
      servo.tick({Vec3(-0.035, 0, 0.005 + 0.008 * std::cos(phase)), DeviceState::kReady, {}});
      held += servo.state().denting.isHeldUp ? 1 : 0;
    }
  }
  EXPECT_GT(held, 100);
}

TEST(StateImage, GoesOnBitForBitFromEveryTickWhileBodiesMeet) {
  RecordedServo servo(kScene + kBricks);
  servo.computeTwice();
  servo.run(4'000);
  EXPECT_GT(servo.state().pairs.places.count, 0U);
}

TEST(StateImage, IsRefusedOnAnotherScene) {
  RecordedServo servo(kScene), other(kScene + kBlock);
  servo.run(500);
  other.run(500);
  EXPECT_FALSE(stateFrom(stateImage(servo.state()), other.scene(), other.config()));
  EXPECT_FALSE(stateFrom(stateImage(other.state()), servo.scene(), servo.config()));
  EXPECT_FALSE(stateFrom("", servo.scene(), servo.config()));
}

TEST(StateImage, IsRefusedOrHarmlessWithAnyByteDamaged) {
  RecordedServo servo(kScene + kBlock + kCushion);
  servo.run(1500);
  const std::string image = stateImage(servo.state());
  std::mt19937 random(1);
  int refused = 0;
  for (std::size_t at = 0; at < image.size(); ++at) {
    std::string damaged = image;
    damaged[at] = static_cast<char>(damaged[at] ^ static_cast<char>(1 + random() % 255));
    auto state = stateFrom(damaged, servo.scene(), servo.config());
    if (!state) {
      ++refused;
      continue;
    }
    for (int i = 0; i < 5; ++i) {
      const StepInput input{1, 0, {Vec3(0.001 * i, 0, -0.001), DeviceState::kReady, {}}};
      EXPECT_TRUE(isFinite(hapticStep(servo.scene(), **state, servo.config(), input).force.written));
    }
  }
  EXPECT_GT(refused, 20);
}

}  // namespace
}  // namespace haptics::state_image_test

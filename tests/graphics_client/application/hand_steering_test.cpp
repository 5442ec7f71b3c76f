#include "graphics_client/application/hand_steering.h"

#include <gtest/gtest.h>

#include <numbers>

namespace haptics::hand_steering_test {
namespace {

constexpr double kFrame_s = 1.0 / 60;
const SurfacePoint kGround{{0.1, 0, 0}, {0, 0, 1}};

class Steered : public testing::Test {
 protected:
  HandCommand frame(bool pressed, std::optional<SurfacePoint> surface) {
    const HandCommand command = steering_.next(
        {.pressed = pressed, .surface = surface, .onPicture = onPicture_, .eye = {0.1, -1, 1}}, hip_, kFrame_s);
    hip_ = command.position;  // a hand that follows at once
    return command;
  }

  HandSteering steering_;
  Vec3 hip_{0, 0, 0.1}, onPicture_{0};
};

TEST_F(Steered, HoversAboveTheSurfaceUntilItPresses) {
  const HandCommand hovering = frame(false, kGround);
  EXPECT_TRUE(hovering.leads);
  EXPECT_EQ(hovering.press_N, 0);
  EXPECT_NEAR(hovering.position.z, HandSteering::kHover_m, 1e-9);
}

TEST_F(Steered, PressesWithTheSetForceOnceItHasComeNear) {
  steering_.setPress_N(2);
  steering_.begin(hip_);
  HandCommand command;
  int frames = 0;
  do {
    const double before_m = hip_.z;
    command = frame(true, kGround);
    if (command.press_N == 0) {
      EXPECT_GE(command.position.z, 0.5 * HandSteering::kHover_m);
    }
    if (frames > 1 && command.press_N == 0) {
      EXPECT_LE(command.position.z, before_m);
    }
  } while (command.press_N == 0 && ++frames < 120);
  EXPECT_EQ(command.press_N, 2);
  EXPECT_EQ(command.position, kGround.position);
  EXPECT_EQ(command.normal, kGround.normal);
}

TEST_F(Steered, LiftsWhereThePointerLeavesTheObject) {
  for (int i = 0; i < 120; ++i) frame(true, kGround);
  const HandCommand command = frame(true, std::nullopt);
  EXPECT_EQ(command.press_N, 0);
  EXPECT_NEAR(command.position.z, HandSteering::kHover_m, 1e-9);
}

TEST_F(Steered, SmoothsNormalsFromFrameToFrame) {
  for (int i = 0; i < 120; ++i) frame(true, kGround);
  const Vec3 tilted = glm::normalize(Vec3(1, 0, 1));
  EXPECT_GT(frame(true, SurfacePoint{{0.1, 0, 0}, tilted}).normal.z, 0.9);
  for (int i = 0; i < 60; ++i) frame(true, SurfacePoint{{0.1, 0, 0}, tilted});
  EXPECT_NEAR(frame(true, SurfacePoint{{0.1, 0, 0}, tilted}).normal.z, tilted.z, 1e-3);
}

TEST_F(Steered, KeepsItsForceWithinWhatThereIs) {
  steering_.setPress_N(100);
  EXPECT_EQ(steering_.press_N(), HandSteering::kMaxPress_N);
  steering_.setPress_N(0);
  EXPECT_EQ(steering_.press_N(), HandSteering::kMinPress_N);
}

TEST_F(Steered, MovesInSpaceFromWhereItIsWithoutAJump) {
  steering_.setMapping(HandSteering::Mapping::kSpace);
  steering_.begin(hip_);
  onPicture_ = {0.5, 0, 0.1};
  EXPECT_EQ(frame(true, std::nullopt).position, Vec3(0, 0, 0.1));
  onPicture_.x += 0.01;
  EXPECT_NEAR(frame(true, std::nullopt).position.x, 0.01, 1e-12);
  onPicture_.x += 1;
  EXPECT_NEAR(frame(false, std::nullopt).position.x, 0.01, 1e-12);
  steering_.moveBy({0, 0, -0.004});
  EXPECT_NEAR(frame(false, std::nullopt).position.z, 0.096, 1e-12);
}

TEST_F(Steered, HoldsTheHandAsItWasTurnedUntilItIsLedAgain) {
  const Quat quarter = glm::angleAxis(std::numbers::pi / 2, Vec3(0, 0, 1));
  for (const auto mapping : {HandSteering::Mapping::kSurface, HandSteering::Mapping::kSpace}) {
    steering_.setMapping(mapping);
    steering_.begin(hip_);
    steering_.turnBy(quarter);
    steering_.turnBy(glm::angleAxis(std::numbers::pi / 2, Vec3(1, 0, 0)));  // of the world, not of the hand
    const Vec3 x = frame(true, kGround).rotation * Vec3(1, 0, 0);
    EXPECT_NEAR(glm::distance(x, Vec3(0, 0, 1)), 0, 1e-12);
    steering_.begin(hip_);
    EXPECT_EQ(frame(true, kGround).rotation, Quat(1, 0, 0, 0));
  }
}

TEST_F(Steered, OpensTheGripperByClicksAndClosesItFromWhereItIs) {
  const double click = std::numbers::pi / 90;
  steering_.begin(hip_);
  EXPECT_EQ(frame(true, kGround).gripper_rad, std::nullopt);
  steering_.openGripper(2, 0.1);
  EXPECT_NEAR(frame(true, kGround).gripper_rad.value(), 0.1 + 2 * click, 1e-12);
  steering_.openGripper(200, 0.1);
  EXPECT_NEAR(frame(true, kGround).gripper_rad.value(), std::numbers::pi, 1e-12);
  steering_.openGripper(-1, 0.5);  // no farther than that does the device go
  EXPECT_NEAR(frame(true, kGround).gripper_rad.value(), 0.5 - click, 1e-12);
  steering_.openGripper(-200, 0.5);
  EXPECT_EQ(frame(true, kGround).gripper_rad, 0);
  steering_.begin(hip_);
  EXPECT_EQ(frame(true, kGround).gripper_rad, std::nullopt);
}

}  // namespace
}  // namespace haptics::hand_steering_test

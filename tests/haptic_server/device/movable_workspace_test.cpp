#include "haptic_server/device/movable_workspace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "common/maths/rotation.h"

namespace haptics::movable_workspace_test {
namespace {

constexpr double kPeriod_s = 1e-3;

/// Is where it is put, and keeps what is written to it.
class PutDevice final : public Device {
 public:
  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] DeviceReading read(std::uint64_t) noexcept override { return reading; }
  void writeTorque(Vec3 written_Nm) noexcept override { torque_Nm = written_Nm; }
  void write(Vec3 written_N) noexcept override { force_N = written_N; }
  void stop() noexcept override {}

  DeviceReading reading{{.state = DeviceState::kReady}};
  Vec3 force_N{0}, torque_Nm{0};

 private:
  DeviceInfo info_;
};

void expectSame(const DeviceReading& a, const DeviceReading& b) {
  EXPECT_LT(glm::distance(a.position, b.position), 1e-15);
  EXPECT_GT(std::abs(glm::dot(a.rotation, b.rotation)), 1 - 1e-15);
}

class MovableWorkspaceTest : public testing::Test {
 protected:
  void move(const WorkspaceCommand& command) { ASSERT_TRUE(workspace_.move(command)); }
  DeviceReading read() { return workspace_.read(0); }

  PutDevice device_;
  MovableWorkspace workspace_{device_, kPeriod_s};
};

TEST_F(MovableWorkspaceTest, IsWhereTheDeviceIsUntilItIsMoved) {
  device_.reading.position = {0.01, -0.02, 0.03};
  device_.reading.rotation = rotationBy({0.1, 0.2, 0.3});
  device_.reading.status.buttons = 1;
  const DeviceReading reading = read();
  EXPECT_EQ(reading.position, device_.reading.position);
  EXPECT_EQ(reading.rotation, device_.reading.rotation);
  EXPECT_FALSE(reading.status.does(HandAction::kClutch));
  workspace_.write({1, 2, 3});
  EXPECT_EQ(device_.force_N, Vec3(1, 2, 3));
}

TEST_F(MovableWorkspaceTest, SaysWhatThePressedButtonsAreBoundTo) {
  move({.clutchButtons = 1, .graspButtons = 0b110, .markButtons = 0b100});
  const auto actions = [this](std::uint32_t buttons) {
    device_.reading.status.buttons = buttons;
    return read().status.actions;
  };
  const auto bit = [](HandAction action) { return static_cast<std::uint8_t>(action); };
  EXPECT_EQ(actions(0b1000), 0);
  EXPECT_EQ(actions(0b1010), bit(HandAction::kGrasp)) << "and one that is free";
  EXPECT_EQ(actions(0b0010), bit(HandAction::kGrasp) | bit(HandAction::kNoOther));
  EXPECT_EQ(actions(0b0100), bit(HandAction::kGrasp) | bit(HandAction::kMark) | bit(HandAction::kNoOther));
  EXPECT_EQ(actions(0b0001), bit(HandAction::kClutch) | bit(HandAction::kNoOther));
  move({.graspButtons = 0, .nextToolButtons = 0b1000});
  EXPECT_EQ(actions(0b0110), bit(HandAction::kMark)) << "what is left out stays as it is";
  EXPECT_EQ(actions(0b1000), bit(HandAction::kNextTool) | bit(HandAction::kNoOther));
  EXPECT_EQ(actions(0), 0);
}

/// 20 mm outside, in a workspace that is turned by a quarter and three times as large.
TEST_F(MovableWorkspaceTest, ComesToAHandThatIsBeyondItsBubbleAndPushesItBack) {
  device_.reading.position = {0.04, 0, 0};
  move({.scale = 3, .rotation = rotationBy({0, 0, std::numbers::pi / 2}), .bubble = Bubble{{0.01, 0, 0}, 0.05}});
  const Vec3 inside = read().position;
  EXPECT_EQ(read().position, inside);
  EXPECT_FALSE(read().added.acts);
  device_.reading.position = {0.08, 0, 0};
  const Vec3 begin = read().position;
  double before_N = 3 * 0.03;
  for (int i = 0; i < 1000; ++i) {
    const double push_N = glm::length(read().added.force_N);
    EXPECT_LE(push_N, before_N + 3 * 0.03 + 1e-12);
    before_N = push_N;
  }
  const DeviceReading reading = read();
  EXPECT_LT(glm::distance(reading.position - begin, Vec3(0, 3 * 0.1 * 1.001, 0)), 1e-9);
  EXPECT_LT(glm::distance(reading.added.force_N, Vec3(0, -3 * 50 * 0.02, 0)), 1e-9) << "1 N on the hand";
  workspace_.write(reading.added.force_N + Vec3(0, -3, 0));
  EXPECT_EQ(read().position, read().position) << "what it is pressed against stops it";
  workspace_.write(reading.added.force_N + Vec3(0, 3, 0));
  EXPECT_GT(read().position.y, reading.position.y) << "what pulls it on does not";

  move({.bubble = Bubble{}});
  for (int i = 0; i < 50; ++i) (void)read();
  EXPECT_EQ(read().position, read().position);
  EXPECT_FALSE(read().added.acts);
}

/// A light hand leans on a wall beyond the border: it comes to rest, pressing as much as stops the workspace.
TEST_F(MovableWorkspaceTest, IsNotDrivenThroughASurface) {
  constexpr double kWall_N_per_m = 2000, kMass_kg = 0.1, kHand_N_per_m = 100, kHand_Ns_per_m = 0.5, kWallAt_m = 0.065;
  move({.bubble = Bubble{Vec3(0), 0.05}});
  double at = 0.05, speed = 0, force_N = 0, largest = 0;
  for (int i = 0; i < 20'000; ++i) {
    device_.reading.position = {at, 0, 0};
    const DeviceReading reading = read();
    force_N = reading.added.force_N.x - std::max(0.0, kWall_N_per_m * (reading.position.x - kWallAt_m));
    workspace_.write({force_N, 0, 0});
    speed += kPeriod_s / kMass_kg * (force_N + kHand_N_per_m * (0.08 - at) - kHand_Ns_per_m * speed);
    at += kPeriod_s * speed;
    if (i > 15'000) largest = std::max(largest, std::abs(speed));
  }
  EXPECT_LT(largest, 1e-3);
  EXPECT_LT(force_N - read().added.force_N.x, -0.2) << "it presses the wall";
  EXPECT_GT(force_N - read().added.force_N.x, -2);
}

TEST_F(MovableWorkspaceTest, WhatIsAddedComesAndGoesSlowly) {
  EXPECT_FALSE(read().added.acts);
  const Wrench wanted{{0, 0.9, 0}, {0, 0, -0.006}};
  workspace_.add(wanted);
  for (int i = 1; i <= 30; ++i) {
    const AddedWrench added = read().added;
    EXPECT_NEAR(added.force_N.y, 0.03 * i, 1e-12);
    EXPECT_NEAR(added.torque_Nm.z, -3e-4 * std::min(i, 20), 1e-15);
  }
  for (int i = 31; i <= 100; ++i) EXPECT_EQ(static_cast<const Wrench&>(read().added), wanted) << "0.1 s after the last";
  for (int i = 1; i < 30; ++i) EXPECT_NEAR(read().added.force_N.y, 0.9 - 0.03 * i, 1e-12);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(read().added.acts);
  workspace_.add(wanted);
  for (int i = 0; i < 50; ++i) (void)read();
  workspace_.add({});
  EXPECT_NEAR(read().added.force_N.y, 0.87, 1e-12);
}

TEST_F(MovableWorkspaceTest, WhatIsAddedIsTheWorlds) {
  move({.scale = 2, .rotation = rotationBy({0, 0, 1})});
  workspace_.add({{0.03, 0, 0}, {}});
  EXPECT_EQ(read().added.force_N, Vec3(0.03, 0, 0));
}

TEST_F(MovableWorkspaceTest, GlidesToItsOffset) {
  move({.offset = Vec3(0.01, 0, 0)});
  for (int i = 1; i <= 99; ++i) EXPECT_NEAR(read().position.x, 1e-4 * i, 1e-12);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(read().position.x, 0.01, 1e-12);
}

TEST_F(MovableWorkspaceTest, ScalesAndTurnsAboutWhereTheHandIs) {
  device_.reading.position = {0.01, 0.02, 0.03};
  device_.reading.rotation = rotationBy({0.3, 0, 0});
  const DeviceReading before = read();
  move({.scale = 4, .rotation = rotationBy({0, 0, std::acos(0.0)})});  // x of the device is y of the world
  expectSame(read(), before);
  device_.reading.position.x += 0.001;
  EXPECT_LT(glm::distance(read().position, before.position + Vec3(0, 0.004, 0)), 1e-15);
  device_.reading.rotation = rotationBy({0.1, 0, 0}) * device_.reading.rotation;
  EXPECT_GT(glm::dot(read().rotation, rotationBy({0, 0.1, 0}) * before.rotation), 1 - 1e-15);
}

// The work of the world's force is scale^2 times that of the hand's, at any pose: the impedance that the hand feels is the
// world's.
TEST_F(MovableWorkspaceTest, ForcesAndTorquesAreThoseOfTheWorldOnTheHand) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  for (const double scale : {0.25, 1.0, 4.0}) {
    const Quat rotation = rotationBy({any(random), any(random), any(random)});
    move({.scale = scale, .rotation = rotation});
    const Vec3 from = read().position, step(any(random), any(random), any(random)), world(any(random), 2, 3);
    device_.reading.position += step;
    const Vec3 way = read().position - from;
    workspace_.write(world);
    workspace_.writeTorque(world);
    EXPECT_NEAR(glm::dot(world, way), scale * std::max(1.0, scale) * glm::dot(device_.force_N, step), 1e-12);
    EXPECT_NEAR(glm::length(device_.force_N), glm::length(world) / std::max(1.0, scale), 1e-12);
    EXPECT_LT(glm::distance(rotation * device_.torque_Nm, world), 1e-12);
  }
}

TEST_F(MovableWorkspaceTest, MovesWithTheHandWhileTheClutchIsPressed) {
  move({.scale = 2, .rotation = rotationBy({0, 0, 1}), .clutchButtons = 0b100});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-0.05, 0.05);
  for (int i = 0; i < 100; ++i) {
    device_.reading.status.buttons = 0b100;
    const DeviceReading before = read();
    EXPECT_TRUE(before.status.does(HandAction::kClutch));
    for (int j = 0; j < 5; ++j) {
      device_.reading.position = {any(random), any(random), any(random)};
      device_.reading.rotation = rotationBy({20 * any(random), 20 * any(random), 20 * any(random)});
      const DeviceReading held = read();
      EXPECT_TRUE(held.status.does(HandAction::kClutch));
      EXPECT_EQ(held.position, before.position);
      EXPECT_EQ(held.rotation, before.rotation);
    }
    device_.reading.status.buttons = 0b011;
    const DeviceReading after = read();
    EXPECT_FALSE(after.status.does(HandAction::kClutch));
    expectSame(after, before);
    device_.reading.position += Vec3(0, 0, 0.001);
    EXPECT_NEAR(read().position.z, before.position.z + 0.002, 1e-12) << "it goes on from there";
  }
}

TEST_F(MovableWorkspaceTest, AReadingThatIsNoneLeavesItAsItIs) {
  move({.clutchButtons = 1});
  (void)read();
  const Vec3 good = device_.reading.position;
  device_.reading.position = Vec3(std::numeric_limits<double>::quiet_NaN());
  for (const std::uint32_t buttons : {1U, 0U}) {
    device_.reading.status.buttons = buttons;
    EXPECT_FALSE(isFinite(read().position));
  }
  move({.scale = 1});
  (void)read();
  device_.reading.position = good;
  EXPECT_EQ(read().position, good);
}

TEST_F(MovableWorkspaceTest, RefusesWhatComesFasterThanItIsRead) {
  int taken = 0;
  while (taken < 1000 && workspace_.move({})) ++taken;
  EXPECT_LT(taken, 1000);
  (void)read();
  EXPECT_TRUE(workspace_.move({}));
}

}  // namespace
}  // namespace haptics::movable_workspace_test

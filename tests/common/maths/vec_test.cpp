#include "common/maths/vec.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <random>

namespace haptics::vec_test {
namespace {

constexpr double kTolerance = 1e-12;  // a few roundings of numbers near 1

Quat turn(double angle_rad, Vec3 axis) { return glm::angleAxis(angle_rad, glm::normalize(axis)); }

Pose randomPose(std::mt19937_64& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&] { return Vec3(number(random), number(random), number(random)); };
  const Vec3 axis = vector();
  return {turn(3 * number(random), axis), vector()};
}

TEST(Pose, IsTheIdentityByDefault) { EXPECT_EQ(toWorld(Pose{}, {1, 2, 3}), Vec3(1, 2, 3)); }

TEST(Pose, TurnsBeforeItMoves) {
  const Pose pose{turn(std::numbers::pi / 2, {0, 0, 1}), {10, 0, 0}};
  EXPECT_LT(glm::distance(toWorld(pose, {1, 0, 0}), Vec3(10, 1, 0)), kTolerance);
}

TEST(Pose, LeadsToTheWorldAndBack) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 100; ++i) {
    const Pose pose = randomPose(random);
    const Vec3 point = randomPose(random).position;
    EXPECT_LT(glm::distance(toLocal(pose, toWorld(pose, point)), point), kTolerance);
    EXPECT_LT(glm::distance(toWorld(pose, toLocal(pose, point)), point), kTolerance);
  }
}

TEST(Interpolate, GivesTheEndsAtZeroAndOne) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 100; ++i) {
    const Pose a = randomPose(random);
    const Pose b = randomPose(random);
    for (const Vec3 point : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
      EXPECT_LT(glm::distance(toWorld(interpolate(a, b, 0), point), toWorld(a, point)), kTolerance);
      EXPECT_LT(glm::distance(toWorld(interpolate(a, b, 1), point), toWorld(b, point)), kTolerance);
    }
  }
}

TEST(Interpolate, IsHalfwayInTheMiddle) {
  const Pose a{turn(0, {0, 0, 1}), {0, 0, 0}};
  const Pose b{turn(1, {0, 0, 1}), {2, 0, 0}};
  const Pose middle = interpolate(a, b, 0.5);
  EXPECT_LT(glm::distance(middle.position, Vec3(1, 0, 0)), kTolerance);
  EXPECT_NEAR(glm::angle(middle.rotation), 0.5, kTolerance);
}

TEST(Interpolate, TakesTheShorterArcWhicheverSignTheQuaternionsHave) {
  const Pose a{turn(0.1, {0, 0, 1}), {0, 0, 0}};
  const Pose b{-turn(0.3, {0, 0, 1}), {0, 0, 0}};
  const Vec3 between = toWorld(interpolate(a, b, 0.5), {1, 0, 0});
  EXPECT_LT(glm::distance(between, Vec3(std::cos(0.2), std::sin(0.2), 0)), kTolerance);
}

TEST(Interpolate, KeepsRotationsAtUnitLength) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 100; ++i) {
    const Pose a = randomPose(random);
    const Pose b = randomPose(random);
    EXPECT_NEAR(glm::length(interpolate(a, b, 0.01 * i).rotation), 1, kTolerance);
  }
}

TEST(IsFinite, FailsForEachBadComponent) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(isFinite(Vec3(bad, 0, 0)));
    EXPECT_FALSE(isFinite(Vec3(0, bad, 0)));
    EXPECT_FALSE(isFinite(Vec3(0, 0, bad)));
    EXPECT_FALSE(isFinite(Pose{Quat(bad, 0, 0, 0), {}}));
    EXPECT_FALSE(isFinite(Pose{Quat(1, bad, 0, 0), {}}));
    EXPECT_FALSE(isFinite(Pose{Quat(1, 0, bad, 0), {}}));
    EXPECT_FALSE(isFinite(Pose{Quat(1, 0, 0, bad), {}}));
    EXPECT_FALSE(isFinite(Pose{Quat(1, 0, 0, 0), {0, bad, 0}}));
  }
  EXPECT_TRUE(isFinite(Pose{}));
  EXPECT_TRUE(isFinite(Vec3(std::numeric_limits<double>::max())));
}

TEST(SquaredLength, IsTheSumOfSquares) { EXPECT_EQ(squaredLength({1, -2, 3}), 14); }

}  // namespace
}  // namespace haptics::vec_test

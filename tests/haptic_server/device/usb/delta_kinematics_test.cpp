#include "haptic_server/device/usb/delta_kinematics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "haptic_server/device/usb/falcon.h"

namespace haptics::test::delta_kinematics_test {
namespace {

using K = DeltaKinematics;

/// A grid over the workspace: a cylinder of 100 mm, 0.08 to 0.17 m from the base, that tapers off at its far end, where
/// the arms are stretched.
void overTheWorkspace(const std::function<void(Vec3)>& visit) {
  for (double z = 0.08; z <= 0.1701; z += 0.01) {
    for (double x = -0.05; x <= 0.0501; x += 0.01) {
      for (double y = -0.05; y <= 0.0501; y += 0.01) {
        if (std::hypot(x, y) <= std::min(0.05, 0.20 - z) + 1e-9) visit({x, y, z});
      }
    }
  }
}

TEST(DeltaKinematics, PutsTheGripWhereUsersMeasuredItForEqualAngles) {
  const std::pair<int, double> kMeasured[] = {
      {-1000, 0.0896}, {-500, 0.1108}, {0, 0.1346}, {500, 0.1569}, {1000, 0.1736}};
  for (const auto& [counts, z] : kMeasured) {
    const auto c = static_cast<std::int16_t>(counts);
    const auto position = K::positionAt(falconAngles({c, c, c}), K::kCentre);
    ASSERT_TRUE(position) << counts;
    EXPECT_NEAR(position->z, z, 1e-4);
    EXPECT_NEAR(std::hypot(position->x, position->y), 0, 1e-9);
  }
}

TEST(DeltaKinematics, ForwardFindsWhatInverseWasGivenOverTheWorkspaceFromItsMiddle) {
  int places = 0;
  double worst = 0;
  overTheWorkspace([&](Vec3 p) {
    const auto angles = K::anglesAt(p);
    ASSERT_TRUE(angles) << p.x << ' ' << p.y << ' ' << p.z;
    const auto found = K::positionAt(*angles, K::kCentre);
    ASSERT_TRUE(found) << p.x << ' ' << p.y << ' ' << p.z;
    worst = std::max(worst, glm::distance(*found, p));
    ++places;
  });
  EXPECT_GT(places, 700);
  EXPECT_LT(worst, 1e-6);
}

TEST(DeltaKinematics, ForwardFindsItAlsoFromWhereverItWasBefore) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> side(-0.035, 0.035), depth(0.085, 0.165);
  const auto anywhere = [&] { return Vec3(side(random), side(random), depth(random)); };
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = anywhere(), start = anywhere();
    const auto found = K::positionAt(*K::anglesAt(p), start);
    ASSERT_TRUE(found);
    EXPECT_LT(glm::distance(*found, p), 1e-6);
  }
}

TEST(DeltaKinematics, DerivativeIsThatOfFiniteDifferencesOverTheWorkspace) {
  double worst = 0;
  overTheWorkspace([&](Vec3 p) {
    const glm::dmat3 rows = K::anglesByPosition(p);
    constexpr double kStep_m = 1e-6;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 step(0);
      step[axis] = kStep_m;
      const auto after = K::anglesAt(p + step), before = K::anglesAt(p - step);
      ASSERT_TRUE(after && before);
      const Vec3 difference = (*after - *before) / (2 * kStep_m);
      worst = std::max(worst, glm::distance(rows[axis], difference) / glm::length(difference));
    }
  });
  EXPECT_LT(worst, 1e-6);
}

TEST(DeltaKinematics, MotorsDoTheWorkThatTheHandFeels) {
  overTheWorkspace([](Vec3 p) {
    const Vec3 force(1.1, -2.2, 0.7), move(1e-7, 2e-7, -3e-7);
    const Vec3 turned = *K::anglesAt(p + move) - *K::anglesAt(p - move);
    const double work = glm::dot(force, 2.0 * move);
    EXPECT_NEAR(glm::dot(K::torquesFor(force, p), turned), work, 1e-4 * glm::length(force) * glm::length(move));
  });
}

TEST(DeltaKinematics, RefusesWhatTheArmsDoNotReach) {
  EXPECT_FALSE(K::anglesAt({0, 0, 0.5}));
  EXPECT_FALSE(K::anglesAt({0.3, 0, 0.13}));
  EXPECT_FALSE(K::positionAt(Vec3(std::nan(""), 0, 0), K::kCentre));
  EXPECT_FALSE(K::positionAt(Vec3(3, -3, 3), K::kCentre));
  EXPECT_EQ(K::torquesFor({1, 2, 3}, {0, 0, 0.5}), Vec3(0));
}

TEST(DeltaKinematics, AStartThatIsNoPlaceDoesNotMatter) {
  const Vec3 p(0.01, -0.02, 0.12);
  for (const Vec3 start : {Vec3(std::nan("")), Vec3(9), Vec3(0, 0, 0.5)}) {
    const auto found = K::positionAt(*K::anglesAt(p), start);
    ASSERT_TRUE(found);
    EXPECT_LT(glm::distance(*found, p), 1e-6);
  }
}

}  // namespace
}  // namespace haptics::test::delta_kinematics_test

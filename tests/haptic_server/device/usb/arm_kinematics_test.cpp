#include "haptic_server/device/usb/arm_kinematics.h"

#include <gtest/gtest.h>

#include <functional>

#include "haptic_server/device/usb/wooden_haptics.h"

namespace haptics::test::arm_kinematics_test {
namespace {

using K = ArmKinematics;

void overTheWorkspace(const std::function<void(Vec3)>& visit) {
  for (double x = -0.1; x <= 0.1001; x += 0.02) {
    for (double y = -0.1; y <= 0.1001; y += 0.02) {
      for (double z = -0.1; z <= 0.1001; z += 0.02) visit({x, y, z});
    }
  }
}

TEST(ArmKinematics, AtRestTheUpperArmIsUprightAndTheForearmPointsAtTheUser) {
  const Vec3 rest = K::positionAt(woodenAngles(Vec3(0))) + K::kOrigin;
  EXPECT_NEAR(rest.x, 0.245, 1e-12);
  EXPECT_NEAR(rest.y, 0, 1e-12);
  EXPECT_NEAR(rest.z, 0.080 + 0.205, 1e-12);
}

TEST(ArmKinematics, ForwardFindsWhatInverseWasGivenOverTheWorkspace) {
  double worst = 0;
  overTheWorkspace([&](Vec3 p) {
    const auto angles = K::anglesAt(p);
    ASSERT_TRUE(angles) << p.x << ' ' << p.y << ' ' << p.z;
    worst = std::max(worst, glm::distance(K::positionAt(*angles), p));
  });
  EXPECT_LT(worst, 1e-6);
}

TEST(ArmKinematics, InverseFindsTheAnglesOfAPoseWithTheElbowAbove) {
  for (double a = -0.6; a <= 0.6; a += 0.2) {
    for (double b = -0.3; b <= 0.8; b += 0.1) {
      for (double c = 0.9; c <= 1.9; c += 0.1) {
        const auto found = K::anglesAt(K::positionAt({a, b, c}));
        ASSERT_TRUE(found);
        EXPECT_LT(glm::distance(*found, Vec3(a, b, c)), 1e-9) << a << ' ' << b << ' ' << c;
      }
    }
  }
}

TEST(ArmKinematics, DerivativeIsThatOfFiniteDifferencesOverTheWorkspace) {
  double worst = 0;
  overTheWorkspace([&](Vec3 p) {
    const Vec3 at = *K::anglesAt(p);
    const glm::dmat3 jacobian = K::positionByAngles(at);
    constexpr double kStep = 1e-6;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 step(0);
      step[axis] = kStep;
      const Vec3 difference = (K::positionAt(at + step) - K::positionAt(at - step)) / (2 * kStep);
      worst = std::max(worst, glm::distance(jacobian[axis], difference) / glm::length(difference));
    }
  });
  EXPECT_LT(worst, 1e-6);
}

TEST(ArmKinematics, MotorsDoTheWorkThatTheHandFeels) {
  overTheWorkspace([](Vec3 p) {
    const Vec3 force(1.1, -2.2, 0.7), move(1e-7, 2e-7, -3e-7);
    const Vec3 turned = *K::anglesAt(p + move) - *K::anglesAt(p - move);
    const double work = glm::dot(force, 2.0 * move);
    EXPECT_NEAR(glm::dot(K::torquesFor(force, *K::anglesAt(p)), turned), work,
                1e-5 * glm::length(force) * glm::length(move));
  });
}

TEST(ArmKinematics, RefusesWhatTheArmDoesNotReachAndPosesThatAreSingular) {
  EXPECT_FALSE(K::anglesAt(Vec3(0.5, 0, 0)));
  EXPECT_FALSE(K::anglesAt(-K::kOrigin + Vec3(0, 0, 0.2))) << "on the column's axis";
  EXPECT_FALSE(K::anglesAt(-K::kOrigin + Vec3(0.4499, 0, 0.080))) << "stretched";
  EXPECT_FALSE(K::anglesAt(Vec3(std::nan(""), 0, 0)));
}

}  // namespace
}  // namespace haptics::test::arm_kinematics_test

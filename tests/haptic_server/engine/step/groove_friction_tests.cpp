#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/eval/combinations/groove_reference.h"
#include "tests/haptic_server/engine/step/surface_world.h"

// Friction where two surfaces hold the IHIP.
namespace haptics::groove_friction_tests {
namespace {

using namespace fixture;

constexpr double kHigh_mu = 0.6, kLow_mu = 0.2;

struct Wall {
  double lean_rad;  ///< Of its normal, from z towards x.
  double mu_stick, mu_slide;
  double stiffness_N_per_m = 800;

  [[nodiscard]] Vec3 normal() const { return {std::sin(lean_rad), 0, std::cos(lean_rad)}; }
};

/// A block whose upper side is the wall; it begins 5 mm below the line x = z = 0 and rises away from it.
ServoObject blockOf(std::uint64_t id, const Wall& wall) {
  const double away = wall.lean_rad > 0 ? -1 : 1;
  const Vec3 up = away * Vec3(std::cos(wall.lean_rad), 0, -std::sin(wall.lean_rad));
  ServoObject block = with(slab(id, 0.045 * up - 0.05 * wall.normal()), friction(wall.mu_stick, wall.mu_slide));
  block.pose.rotation = Quat(std::cos(wall.lean_rad / 2), 0, std::sin(wall.lean_rad / 2), 0);
  block.stiffness_N_per_m = wall.stiffness_N_per_m;
  block.damping_Ns_per_m = 0;
  return block;
}

/// Of a hand below the line, the normal forces N_1 and N_2.
std::pair<double, double> pressing_N(const Wall& a, const Wall& b, Vec3 hip) {
  const eval::GrooveReference groove({a.normal(), a.stiffness_N_per_m}, {b.normal(), b.stiffness_N_per_m});
  const auto [first, second] = groove.pressing_N({-glm::dot(a.normal(), hip), -glm::dot(b.normal(), hip)});
  return {first, second};
}

constexpr double kDeep_m = 0.002;

/// Down into the groove, then slowly along it.
Vec3 alongGroove(std::uint64_t tick) {
  const double down = std::min(1.0, static_cast<double>(tick) / 200);
  const double along = tick > 300 ? 5e-6 * static_cast<double>(tick - 300) : 0;
  return {0, -0.01 + along, 0.004 - (0.004 + kDeep_m) * down};
}
constexpr std::uint64_t kTicks = 1500;

TEST(GrooveFriction, IsThatOfEachWallUnderItsOwnNormalForce) {
  const Wall grooves[][2] = {
      {{0.8, 0.4, 0.3}, {-0.8, 0.4, 0.3}},          {{0.8, 0.7, kHigh_mu}, {-0.8, 0.3, kLow_mu}},
      {{0.3, 0.7, kHigh_mu}, {-1.1, 0.3, kLow_mu}}, {{0.9, 0.7, kHigh_mu, 500}, {-0.5, 0.3, kLow_mu, 1000}},
      {{0.9, 0, 0}, {-0.5, 0.3, kLow_mu}},
  };
  for (const auto& [left, right] : grooves) {
    for (const bool swapped : {false, true}) {
      VirtualServo servo(alongGroove, kConfig,
                         swapped ? sceneOf(1, {blockOf(1, right), blockOf(2, left)})
                                 : sceneOf(1, {blockOf(1, left), blockOf(2, right)}));
      const auto [left_N, right_N] = pressing_N(left, right, Vec3(0, 0, -kDeep_m));
      double most_N = 0;
      TelemetrySample sample;
      while (servo.tick() < kTicks) {
        sample = servo.step();
        most_N = std::max(most_N, -sample.force.friction.y);
      }
      const double stick_N = left.mu_stick * left_N + right.mu_stick * right_N;
      const double slide_N = left.mu_slide * left_N + right.mu_slide * right_N;
      EXPECT_NEAR(-sample.force.friction.y, slide_N, 0.01 * slide_N) << left.lean_rad << " " << left.mu_slide;
      EXPECT_LE(most_N, 1.01 * stick_N);
      EXPECT_GE(most_N, slide_N);
      EXPECT_EQ(sample.frictionState, FrictionState::kSliding);
    }
  }
}

TEST(GrooveFriction, BreaksAwayAtTheSumOfWhatSticks) {
  const Wall left{0.8, 0.5, 0.4}, right{-0.8, 0.5, 0.4};
  VirtualServo servo(alongGroove, kConfig, sceneOf(1, {blockOf(1, left), blockOf(2, right)}));
  const auto [left_N, right_N] = pressing_N(left, right, Vec3(0, 0, -kDeep_m));
  double most_N = 0;
  while (servo.tick() < kTicks) most_N = std::max(most_N, -servo.step().force.friction.y);
  EXPECT_NEAR(most_N, 0.5 * (left_N + right_N), 0.01 * most_N);
}

/// From wall to wall, so that first one and then the other pushes most, while the hand is drawn to and fro.
Vec3 fromWallToWall(std::uint64_t tick) {
  const double t = 1e-3 * static_cast<double>(tick);
  const double down = std::min(1.0, 5 * t);
  return {0.004 * std::sin(6 * t), 0.003 * std::sin(4 * t), 0.004 - 0.0065 * down};
}

TEST(GrooveFriction, HasNoStepWhereTheOtherWallPushesMostOrOneLetsGo) {
  for (const double mu : {0.0, kLow_mu, kHigh_mu}) {
    VirtualServo servo(fromWallToWall, kConfig,
                       sceneOf(1, {blockOf(1, {0.8, mu, mu, 500}), blockOf(2, {-0.8, kHigh_mu, kHigh_mu, 1000})}));
    Vec3 before_N = servo.run(250).force.friction;
    bool hasSticking = false, hasSliding = false, hasOne = false, hasSeveral = false;
    while (servo.tick() < 2500) {
      const TelemetrySample sample = servo.step();
      EXPECT_LE(glm::distance(sample.force.friction, before_N), 0.06) << mu << " " << servo.tick();
      before_N = sample.force.friction;
      hasSliding |= sample.frictionState == FrictionState::kSliding;
      hasSticking |= sample.frictionState == FrictionState::kSticking;
      (servo.state().contact.surfaces().size() > 1 ? hasSeveral : hasOne) = true;
    }
    EXPECT_TRUE(hasSeveral);
    EXPECT_TRUE(hasOne);
    EXPECT_TRUE(hasSliding) << mu;
    EXPECT_TRUE(hasSticking) << mu;
  }
}

}  // namespace
}  // namespace haptics::groove_friction_tests

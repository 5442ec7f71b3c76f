#include <gtest/gtest.h>

#include <vector>

#include "tests/haptic_server/engine/motion/bodies.h"

namespace haptics::test::joint_motion_test {
namespace {

/// A bar that hangs from an axis along y, at its end, turned up to an angle.
Moving pendulum(double angle) {
  RigidBody bar = boxOf({0.02, 0.02, 0.2}, 0.3);
  bar.freedom = Freedom::kHinge;
  bar.joint = {{0, 0, 0.1}, {0, 1, 0}, -10, 10};
  Moving swinging(bar, Pose{{1, 0, 0, 0}, {0.3, 0, -0.1}});
  swinging.state.coordinate = angle;
  return swinging;
}

/// About the hinge, kg m^2.
double momentOf(const RigidBody& bar) {
  return bar.mass.mass_kg * (0.02 * 0.02 + 0.2 * 0.2) / 12 + bar.mass.mass_kg * 0.01;
}

/// Seconds of a swing, over many.
double periodOf(Moving& swinging) {
  std::vector<double> crossings;
  for (int i = 0; i < 30'000; ++i) {
    const double before = swinging.state.coordinate;
    swinging.tick();
    const double after = swinging.state.coordinate;
    if (before < 0 && after >= 0) crossings.push_back((i + before / (before - after)) * kPeriod_s);
  }
  return (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
}

TEST(Hinge, MakesAPendulumOfTheRightPeriodAtAnyAmplitude) {
  for (const double amplitude : {0.01, 0.5, 1.5, 2.8}) {
    Moving bar = pendulum(amplitude);
    const double slow = std::sqrt(momentOf(bar.body) / (bar.body.mass.mass_kg * 9.81 * 0.1));
    const double period = 4 * slow * std::comp_ellint_1(std::sin(amplitude / 2));
    EXPECT_NEAR(periodOf(bar), period, 0.005 * period) << amplitude;
  }
}

TEST(Hinge, KeepsItsEnergyWhereThePapersExplicitEulerGainsWithoutEnd) {
  Moving bar = pendulum(0.5);
  const double drop = 0.3 * 9.81 * 0.1;                             // N m
  const double lowest = bar.energy() - drop * (1 - std::cos(0.5));  // J, hanging
  const double atFirst = bar.energy() - lowest;
  double worst = 0;
  double angle = 0.5;
  double rate = 0;
  for (int i = 0; i < 60'000; ++i) {
    bar.tick();
    worst = std::max(worst, std::abs(bar.energy() - lowest - atFirst));
    const double acceleration = -drop * std::sin(angle) / momentOf(bar.body);
    angle += kPeriod_s * rate;  // explicit: the old rate
    rate += kPeriod_s * acceleration;
  }
  const double explicitGain = (0.5 * momentOf(bar.body) * rate * rate + drop * (1 - std::cos(angle))) / atFirst;
  EXPECT_LT(worst, 0.01 * atFirst);
  EXPECT_NEAR(bar.energy() - lowest, atFirst, 0.01 * atFirst);
  EXPECT_GT(explicitGain, 5);
  RecordProperty("semi_implicit_worst_relative", std::to_string(worst / atFirst));
  RecordProperty("explicit_after_a_minute_relative", std::to_string(explicitGain));
}

TEST(Hinge, TurnsAsTheForceAtItsArmHasIt) {
  RigidBody door = floating(boxOf({0.2, 0.01, 0.3}, 0.5));
  door.freedom = Freedom::kHinge;
  door.joint.anchor_m = {-0.1, 0, 0};
  door.joint.axis = {0, 0, 1};
  const Pose closed{glm::angleAxis(0.7, glm::normalize(Vec3(1, 2, 3))), {0.1, 0.2, 0.3}};
  Moving turning(door, closed);
  const Vec3 normal = closed.rotation * Vec3(0, 1, 0);
  const Push push{2.0 * normal, toWorld(closed, {0.1, 0, 0.1})};
  turning.run(0.05, push);
  const double moment = 0.5 * (0.2 * 0.2 + 0.01 * 0.01) / 12 + 0.5 * 0.01;
  EXPECT_NEAR(turning.state.rate_per_s, 0.05 * 2 * 0.2 / moment, 2e-3 * 0.05 * 2 * 0.2 / moment);
  const Vec3 onAxis = {-0.1, 0, 0.123};
  EXPECT_LT(glm::distance(toWorld(turning.pose(), onAxis), toWorld(closed, onAxis)), 1e-12);
}

TEST(Joint, StopsAtItsLimitsAndComesBack) {
  Moving bar = pendulum(0);
  bar.body.joint.lowest = -0.3;
  bar.body.joint.highest = 0.4;
  double least = 0;
  double most = 0;
  for (const double force : {5.0, -5.0, 5.0}) {
    for (int i = 0; i < 1000; ++i) {
      bar.tick({{force, 0, 0}, toWorld(bar.pose(), {0, 0, -0.1})});
      least = std::min(least, bar.state.coordinate);
      most = std::max(most, bar.state.coordinate);
    }
  }
  EXPECT_EQ(least, -0.3);
  EXPECT_EQ(most, 0.4);
  const double energy = bar.energy();
  bar.run(0.05);
  EXPECT_GT(bar.state.coordinate, -0.29) << "hangs free of its limit";
  EXPECT_NEAR(bar.energy(), energy, 1e-2 * 0.3 * 9.81 * 0.1);
}

TEST(Slider, MovesAlongItsAxisOnlyAndSpringsBack) {
  RigidBody knob = boxOf({0.03, 0.03, 0.01}, 0.1);
  knob.freedom = Freedom::kSlider;
  knob.joint.axis = glm::normalize(Vec3(1, 0, 1));
  knob.joint.lowest = -0.02;
  knob.joint.highest = 0;
  knob.spring.stiffness_N_per_m = 500;
  knob.spring.damping_Ns_per_m = 2;
  knob.gravity_m_per_s2 = Vec3(0);
  Moving pressed(knob, Pose{});
  const Push push{{0, 3, -4}, {0.01, 0, 0}};
  pressed.run(2, push);
  EXPECT_NEAR(pressed.state.coordinate, -4 / std::sqrt(2.0) / 500, 1e-6);
  EXPECT_EQ(pressed.pose().rotation, Quat(1, 0, 0, 0));
  EXPECT_EQ(pressed.pose().position.y, 0);
  pressed.run(0.3, {{0, 0, -400}, Vec3(0)});
  EXPECT_EQ(pressed.state.coordinate, -0.02);
  pressed.run(2);
  EXPECT_EQ(pressed.state.condition, BodyCondition::kAsleep);
  EXPECT_NEAR(pressed.state.coordinate, 0, 1e-5);
}

TEST(Joint, IsNotMadeUnstableByAnySpringOrDamping) {
  for (const Freedom freedom : {Freedom::kHinge, Freedom::kSlider}) {
    Moving bar = pendulum(0);
    bar.body.freedom = freedom;
    bar.body.spring = {1e9, 1e9, 1e9, 1e9};
    bar.run(1, {{3, 2, 1}, {0.3, 0, -0.2}});
    EXPECT_LT(std::abs(bar.state.coordinate), 1e-3);
    EXPECT_LT(std::abs(bar.state.rate_per_s), 1e-3);
  }
}

TEST(Joint, WhoseForceIsNoNumberIsFrozen) {
  Moving bar = pendulum(0.3);
  bar.run(0.1);
  const Pose before = bar.pose();
  bar.tick({{std::nan(""), 0, 0}, Vec3(0)});
  EXPECT_EQ(bar.state.condition, BodyCondition::kNonFinite);
  EXPECT_EQ(bar.pose(), before);
}

TEST(Joint, DoesNotFallAsleepAtATurningPoint) {
  Moving bar = pendulum(0.005);
  for (int i = 0; i < 10'000; ++i) {
    bar.tick();
    ASSERT_EQ(bar.state.condition, BodyCondition::kAwake) << i;
  }
}

}  // namespace
}  // namespace haptics::test::joint_motion_test

#include <gtest/gtest.h>

#include "common/maths/rotation.h"
#include "tests/haptic_server/engine/motion/bodies.h"

namespace haptics::test::free_motion_test {
namespace {

/// An asymmetric brick that spins about nearly its middle axis, which is unstable: it turns over again and again.
Moving tumbling() {
  Moving brick(floating(boxOf({0.02, 0.05, 0.09}, 0.3)), Pose{glm::normalize(Quat(0.8, 0.1, -0.3, 0.5)), Vec3(0)});
  const Vec3 m = brick.body.mass.moments;
  Vec3 spin(0.05);
  for (int i = 0; i < 3; ++i) {
    const double others[2] = {m[(i + 1) % 3], m[(i + 2) % 3]};
    if ((m[i] - others[0]) * (m[i] - others[1]) < 0) spin[i] = 20;
  }
  brick.state.angularMomentum_Nms = brick.state.axes * (m * spin);
  return brick;
}

/// As moments are integrated, so must what is seen: omega, from the poses alone.
Vec3 seenAngularMomentum(const RigidBody& body, const Pose& before, const Pose& after) {
  const Vec3 omega = rotationVector(after.rotation * glm::conjugate(before.rotation)) / kPeriod_s;
  const Quat axes = interpolate(before, after, 0.5).rotation * body.mass.principal;
  return axes * (body.mass.moments * (glm::conjugate(axes) * omega));
}

TEST(FreeBody, GainsTheMomentumThatThePushGives) {
  Moving box(floating(boxOf({0.04, 0.05, 0.06}, 0.2)), Pose{});
  Vec3 given(0);
  Vec3 turning(0);
  Pose before;
  for (int i = 0; i < 2000; ++i) {
    const double t = i * kPeriod_s;
    const Push push{{0.5 * std::sin(3 * t), 0.2, -0.1 * t}, toWorld(box.pose(), {0.02, 0.01, 0.03})};
    given += kPeriod_s * push.force_N;
    turning += kPeriod_s * glm::cross(push.place_m - box.pose().position, push.force_N);
    before = box.pose();
    box.tick(push);
  }
  const Vec3 seen = box.body.mass.mass_kg * (box.pose().position - before.position) / kPeriod_s;
  EXPECT_LT(glm::distance(seen, given), 1e-3 * glm::length(given));
  EXPECT_LT(glm::distance(seenAngularMomentum(box.body, before, box.pose()), turning), 1e-3 * glm::length(turning));
}

TEST(FreeBody, KeepsItsAngularMomentumAndEnergyInASpinOfAMinute) {
  Moving brick = tumbling();
  const Vec3 momentum = brick.state.angularMomentum_Nms;
  const double energy = brick.energy();
  double worstMomentum = 0;
  double worstEnergy = 0;
  int turnedOver = 0;
  Vec3 sense(0);
  for (int i = 0; i < 60'000; ++i) {
    const Pose before = brick.pose();
    brick.tick();
    worstMomentum =
        std::max(worstMomentum, glm::distance(seenAngularMomentum(brick.body, before, brick.pose()), momentum));
    worstEnergy = std::max(worstEnergy, std::abs(brick.energy() - energy));
    const Vec3 along = glm::normalize(glm::conjugate(brick.state.axes) * momentum);
    for (int k = 0; k < 3; ++k) {
      if (std::abs(along[k]) < 0.95) continue;
      if (along[k] * sense[k] < 0) ++turnedOver;
      sense[k] = along[k];
    }
  }
  EXPECT_GT(turnedOver, 10) << "not unstable: the test says nothing";
  EXPECT_LT(worstMomentum, 1e-3 * glm::length(momentum));
  EXPECT_LT(worstEnergy, 1e-3 * energy);
  RecordProperty("worst_momentum_error", std::to_string(worstMomentum / glm::length(momentum)));
  RecordProperty("worst_energy_error", std::to_string(worstEnergy / energy));
}

TEST(FreeBody, ThatIsSymmetricSpinsOnAsItDid) {
  Moving cube(floating(boxOf({0.04, 0.04, 0.04}, 0.1)), Pose{});
  const Vec3 spin(1, 2, -3);
  cube.state.angularMomentum_Nms = cube.body.mass.moments.x * spin;
  cube.run(60);
  EXPECT_LT(glm::distance(cube.velocity().angular, spin), 1e-6);
  const Quat there = rotationBy(60.0 * spin);
  EXPECT_GT(std::abs(glm::dot(there, cube.pose().rotation)), 1 - 1e-9);
}

TEST(FreeBody, FallsAsGravityHasIt) {
  Moving box(boxOf({0.04, 0.05, 0.06}, 0.2), Pose{{1, 0, 0, 0}, {0, 0, 5}});
  box.run(0.5);
  EXPECT_NEAR(box.pose().position.z, 5 - 0.5 * 9.81 * 0.25, 9.81 * kPeriod_s * 0.5);
  EXPECT_NEAR(box.velocity().linear.z, -9.81 * 0.5, 1e-12);
}

TEST(FreeBody, IsSlowedByDampingAtItsRate) {
  Moving box(floating(boxOf({0.04, 0.05, 0.06}, 0.2)), Pose{});
  box.body.linearDamping_per_s = 2;
  box.body.angularDamping_per_s = 3;
  box.state.momentum_Ns = {1, 0, 0};
  box.state.angularMomentum_Nms = {0, 0.001, 0};
  box.run(1);
  EXPECT_NEAR(box.state.momentum_Ns.x, std::exp(-2.0), 0.005 * std::exp(-2.0));
  EXPECT_NEAR(box.state.angularMomentum_Nms.y, 0.001 * std::exp(-3.0), 0.01 * 0.001 * std::exp(-3.0));
}

TEST(FreeBody, OnASpringSwingsAtItsFrequencyAndComesToRestWhereItWas) {
  const Pose rest{glm::normalize(Quat(0.9, 0.2, 0.1, 0)), {0.1, 0.2, 0.3}};
  Moving knob(floating(boxOf({0.04, 0.05, 0.06}, 0.2)), rest);
  knob.body.spring = {200, 0, 0.5, 0};
  knob.state.centre_m += Vec3(0.01, 0, 0);
  const double period = 2 * kPi * std::sqrt(0.2 / 200);
  knob.run(10 * period);
  EXPECT_NEAR(knob.pose().position.x, rest.position.x + 0.01, 5e-4) << "after ten whole swings";

  knob.body.spring = {200, 1, 0.5, 1e-3};
  knob.run(4, {});
  EXPECT_EQ(knob.state.condition, BodyCondition::kAsleep);
  EXPECT_LT(glm::distance(knob.pose().position, rest.position), 1e-5);
}

TEST(FreeBody, IsNotMadeUnstableByAnySpringOrDamping) {
  for (const double spring : {0.0, 1e3, 1e6, 1e9}) {
    for (const double damping : {0.0, 1e3, 1e6, 1e9}) {
      if (spring + damping == 0) continue;
      Moving knob(floating(boxOf({0.01, 0.02, 0.03}, 0.01)), Pose{});
      knob.body.spring = {spring, damping, spring, damping};
      knob.body.linearDamping_per_s = knob.body.angularDamping_per_s = damping;
      knob.run(0.1, {{1, 0.5, 0.2}, {0.01, 0.01, 0.01}});
      knob.run(1);
      EXPECT_LT(glm::length(knob.pose().position), 0.01) << spring << ' ' << damping;
      EXPECT_LT(glm::length(rotationVector(knob.pose().rotation)), 0.2) << spring << ' ' << damping;
      EXPECT_NE(knob.state.condition, BodyCondition::kNonFinite);
    }
  }
}

TEST(FreeBody, IsStoppedAtTheWorldsEndAndStaysThere) {
  Moving box(boxOf({0.04, 0.05, 0.06}, 0.2), Pose{});
  box.run(5);
  EXPECT_EQ(box.state.condition, BodyCondition::kOutOfBounds);
  const Pose there = box.pose();
  EXPECT_LE(glm::length(there.position), kWorldRadius_m);
  EXPECT_GT(glm::length(there.position), 0.9 * kWorldRadius_m);
  box.run(0.1, {{10, 0, 10}, there.position});
  EXPECT_EQ(box.pose(), there);
}

TEST(FreeBody, IsFrozenWhereItWasByAForceThatIsNoNumber) {
  for (const double bad : {std::nan(""), HUGE_VAL, 1e308}) {
    Moving box(floating(boxOf({0.04, 0.05, 0.06}, 0.2)), Pose{});
    box.run(0.1, {{0.1, 0, 0}, {0, 0.01, 0}});
    const Pose before = box.pose();
    box.tick({{bad, 0, bad}, {0, 1e10, 0}});
    EXPECT_NE(box.state.condition, BodyCondition::kAwake) << bad;
    EXPECT_EQ(box.pose(), before);
    box.run(0.1);
    EXPECT_EQ(box.pose(), before);
  }
}

}  // namespace
}  // namespace haptics::test::free_motion_test

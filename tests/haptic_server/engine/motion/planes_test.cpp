#include <gtest/gtest.h>

#include <vector>

#include "tests/haptic_server/engine/motion/bodies.h"

namespace haptics::test::planes_test {
namespace {

constexpr double kGravity = 9.81;

RigidBody onFloor(RigidBody body, double friction = 0.5) {
  body.planes[0] = {{0, 0, 1}, 0, friction};
  body.planeCount = 1;
  return body;
}

Pose at(Vec3 position, Quat rotation = {1, 0, 0, 0}) { return {rotation, position}; }

/// Lowest point over the floor, m.
double clearance(const Moving& m) {
  double lowest = HUGE_VAL;
  for (const Vec3 p : m.body.support) lowest = std::min(lowest, (m.state.centre_m + m.state.axes * p).z);
  return lowest;
}

/// Too little to move anything, but it keeps awake.
Push nudge(const Moving& m) { return {{1e-12, 0, 0}, m.state.centre_m}; }

TEST(BodyOnAPlane, LiesStillAndThenSleeps) {
  Moving box(onFloor(boxOf({0.04, 0.05, 0.06}, 0.2)), at({0, 0, 0.03}));
  const Pose before = box.pose();
  double moved = 0;
  for (int i = 0; i < 10'000; ++i) {
    box.tick(nudge(box));
    moved = std::max(moved, glm::distance(box.pose().position, before.position));
  }
  EXPECT_LT(moved, 1e-6);
  EXPECT_GT(glm::dot(box.pose().rotation, before.rotation), 1 - 1e-12);
  box.run(kStill_s + 0.01);
  EXPECT_EQ(box.state.condition, BodyCondition::kAsleep);
}

TEST(BodyOnAPlane, ComesToRestWhateverWayItIsDroppedAndNeverGainsEnergy) {
  const std::vector<TriMesh> meshes = {makeBox({0.04, 0.05, 0.06}, 1).value(), makeCylinder(0.02, 0.05, 64).value(),
                                       makeTorus(0.04, 0.01, 64, 32).value()};
  for (const TriMesh& mesh : meshes) {
    for (int k = 0; k < 8; ++k) {
      const Quat turn = glm::normalize(Quat(std::cos(k), std::sin(2 * k), std::cos(3 * k), std::sin(5 * k)));
      Moving body(onFloor(bodyOf(mesh, 0.2)), at({0, 0, 0.15}, turn));
      body.state.angularMomentum_Nms = 2e-4 * Vec3(std::sin(k), std::cos(k), 1);
      double energy = body.energy();
      double gained = 0;
      double deepest = 0;
      double last = 0;
      for (int i = 0; i < 12'000 && body.state.condition == BodyCondition::kAwake; ++i) {
        body.tick();
        gained += std::max(body.energy() - energy, 0.0);
        energy = body.energy();
        deepest = std::min(deepest, clearance(body));
        last = i * kPeriod_s;
      }
      EXPECT_EQ(body.state.condition, BodyCondition::kAsleep) << k;
      EXPECT_LT(gained, 0.01 * 0.2 * kGravity * 0.15) << k;
      EXPECT_GT(deepest, -1e-3) << k << ": of 1.7 mm that it falls in a tick";
      EXPECT_NEAR(clearance(body), 0, 2e-5) << k;
      RecordProperty("slept_after_s", std::to_string(last));
    }
  }
}

TEST(BodyOnAPlane, StandsAPushBelowFrictionAndSlidesUnderOneAbove) {
  const double weight = 0.2 * kGravity;
  Moving box(onFloor(boxOf({0.05, 0.05, 0.03}, 0.2), 0.4), at({0, 0, 0.015}));
  box.run(0.1);
  const Vec3 start = box.pose().position;
  for (int i = 0; i < 1000; ++i) box.tick({{0.39 * weight, 0, 0}, box.state.centre_m});
  EXPECT_LT(glm::distance(box.pose().position, start), 1e-5);
  for (int i = 0; i < 500; ++i) box.tick({{0.6 * weight, 0, 0}, box.state.centre_m});
  EXPECT_NEAR(box.velocity().linear.x, 0.2 * kGravity * 0.5, 0.01 * 0.2 * kGravity * 0.5);
  EXPECT_NEAR(clearance(box), 0, 2e-5);
  const double speed = box.velocity().linear.x;
  const double from = box.pose().position.x;
  box.run(2);
  EXPECT_EQ(box.state.condition, BodyCondition::kAsleep);
  const double way = speed * speed / (2 * 0.4 * kGravity);
  EXPECT_NEAR(box.pose().position.x - from, way, 0.01 * way);
}

TEST(BodyOnAPlane, IsSpunByAPushBesideItsCentreAndStopsTurning) {
  Moving box(onFloor(boxOf({0.08, 0.02, 0.02}, 0.1), 0.3), at({0, 0, 0.01}));
  for (int i = 0; i < 100; ++i) box.tick({{0, 0.5, 0}, toWorld(box.pose(), {0.035, 0, 0})});
  EXPECT_GT(box.velocity().angular.z, 3);
  EXPECT_LT(std::hypot(box.velocity().angular.x, box.velocity().angular.y), 0.05 * box.velocity().angular.z);
  box.run(3);
  EXPECT_EQ(box.state.condition, BodyCondition::kAsleep);
  EXPECT_NEAR(clearance(box), 0, 2e-5);
}

TEST(BodyOnAPlane, IsTippedOverByAPushAboveItsEdgeButNotByAWeakerOne) {
  // Over the far edge at half its width: F h = m g w / 2.
  const double balance = 0.2 * kGravity * 0.02 / 0.1;
  for (const double part : {0.97, 1.03}) {
    Moving tower(onFloor(boxOf({0.04, 0.04, 0.1}, 0.2), 0.9), at({0, 0, 0.05}));
    tower.run(0.1);
    for (int i = 0; i < 3000 && (tower.pose().rotation * Vec3(0, 0, 1)).z > std::cos(0.45); ++i) {
      tower.tick({{part * balance, 0, 0}, toWorld(tower.pose(), {-0.02, 0, 0.05})});
    }
    tower.run(5);
    EXPECT_EQ(tower.state.condition, BodyCondition::kAsleep);
    const double upright = (tower.pose().rotation * Vec3(0, 0, 1)).z;
    EXPECT_NEAR(upright, part > 1 ? 0 : 1, 1e-3) << part;
    EXPECT_NEAR(tower.pose().position.z, part > 1 ? 0.02 : 0.05, 5e-5);
  }
}

TEST(BodyOnAPlane, HoldsOnASlopeThatIsLessThanItsFrictionAndSlidesOnASteeperOne) {
  for (const double slope : {0.3, 0.5}) {
    const double friction = std::tan(0.4);
    RigidBody brick = boxOf({0.06, 0.06, 0.02}, 0.1);
    const Quat turn = glm::angleAxis(slope, Vec3(0, 1, 0));
    brick.planes[0] = {turn * Vec3(0, 0, 1), 0, friction};
    brick.planeCount = 1;
    Moving body(brick, at(turn * Vec3(0, 0, 0.01), turn));
    body.run(0.5);
    const double way = glm::length(body.pose().position - turn * Vec3(0, 0, 0.01));
    const double acceleration = kGravity * (std::sin(slope) - friction * std::cos(slope));
    if (acceleration > 0) {
      EXPECT_NEAR(way, 0.5 * acceleration * 0.25, 0.01 * 0.5 * acceleration * 0.25);
    } else {
      EXPECT_LT(way, 1e-5);
    }
  }
}

TEST(BodyOnAPlane, RollsAsARoundBodyDoes) {
  const double slope = 0.2;
  const Quat turn = glm::angleAxis(slope, Vec3(0, 1, 0));
  RigidBody ball = bodyOf(makeSphere(0.03, 64).value(), 0.1);
  ball.planes[0] = {turn * Vec3(0, 0, 1), 0, 0.8, 0};
  ball.planeCount = 1;
  Moving rolling(ball, at(turn * Vec3(0, 0, 0.03)));
  rolling.run(0.5);
  // Its facets take some.
  const double speed = 0.5 * kGravity * std::sin(slope) / 1.4;
  EXPECT_LT(glm::length(rolling.velocity().linear), 1.01 * speed);
  EXPECT_GT(glm::length(rolling.velocity().linear), 0.8 * speed);
  EXPECT_NEAR(rolling.velocity().angular.y * 0.03, glm::length(rolling.velocity().linear), 0.03 * speed);
}

TEST(BodyOnAPlane, StopsInACornerOfThree) {
  RigidBody box = boxOf({0.04, 0.04, 0.04}, 0.1);
  box.planes[0] = {{0, 0, 1}, 0, 0.3};
  box.planes[1] = {{-1, 0, 0}, -0.2, 0.3};
  box.planes[2] = {{0, -1, 0}, -0.2, 0.3};
  box.planeCount = 3;
  Moving pushed(box, at({0, 0.1, 0.02}));
  for (int i = 0; i < 2000; ++i) pushed.tick({{1, 0.7, 0}, pushed.state.centre_m});
  pushed.run(2);
  EXPECT_EQ(pushed.state.condition, BodyCondition::kAsleep);
  EXPECT_LT(glm::distance(pushed.pose().position, Vec3(0.18, 0.18, 0.02)), 1e-4);
}

TEST(BodyOnAPlane, ThatWasPutIntoItRisesSlowlyInsteadOfJumping) {
  Moving box(onFloor(boxOf({0.04, 0.04, 0.04}, 0.1)), at({0, 0, 0.01}));
  double highest = 0;
  for (int i = 0; i < 2000; ++i) {
    box.tick();
    highest = std::max(highest, box.pose().position.z);
  }
  EXPECT_LT(highest, 0.0201);
  EXPECT_NEAR(clearance(box), 0, 2e-5);
}

TEST(SleepingBody, DoesNotMoveByABitUntilItIsPushed) {
  Moving box(onFloor(boxOf({0.04, 0.04, 0.04}, 0.1)), at({0, 0, 0.0201}));
  box.run(2);
  ASSERT_EQ(box.state.condition, BodyCondition::kAsleep);
  const Pose before = box.pose();
  box.run(1);
  EXPECT_EQ(box.pose(), before);
  EXPECT_EQ(glm::length(box.velocity().linear), 0);
  box.tick({{2, 0, 0}, before.position});
  EXPECT_EQ(box.state.condition, BodyCondition::kAwake);
  EXPECT_GT(box.pose().position.x, before.position.x);
}

}  // namespace
}  // namespace haptics::test::planes_test

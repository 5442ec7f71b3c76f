#include <gtest/gtest.h>

#include "common/mesh/generators.h"
#include "haptic_server/engine/motion/solid.h"
#include "haptic_server/engine/motion/support_points.h"
#include "haptic_server/engine/step/moving_bodies.h"
#include "tests/haptic_server/engine/step/surface_world.h"

namespace haptics::fixture::moving_bodies_tests {
namespace {

constexpr double kMass_kg = 0.2;
const StepConfig kConfig{.maxForce_N = 20};

RigidBody floatingBody(const TriMesh& mesh) {
  const Solid solid = solidOf(mesh.vertices, mesh.triangles);
  RigidBody body;
  EXPECT_EQ(spreadMass(kMass_kg, solid.centre, kMass_kg / solid.volume_m3 * solid.inertia, body.mass),
            MassDefect::kNone);
  body.setSupport(supportPoints(mesh.vertices));
  body.gravity_m_per_s2 = Vec3(0);
  return body;
}

TriMesh boxMesh(Vec3 size_m) { return makeBox(size_m, 2).value(); }

ServoObject moving(ServoObject object, const RigidBody& body) {
  object.motion = std::make_shared<RigidBody>(body);
  return object;
}

/// A box of 60 mm around the origin.
ServoObject floatingBox(Vec3 at = Vec3(0), std::uint64_t id = 1) {
  const TriMesh mesh = boxMesh(Vec3(0.06));
  return moving(objectOf(id, surfaceOf(mesh), at), floatingBody(mesh));
}

/// From one place to another in a time, then still.
VirtualServo::Trajectory way(Vec3 from, Vec3 to, double seconds) {
  return
      [=](std::uint64_t tick) { return glm::mix(from, to, std::min(1.0, static_cast<double>(tick) * 1e-3 / seconds)); };
}

const RigidState& bodyState(const VirtualServo& servo, std::size_t i = 0) { return servo.state().moving[i].state; }

TEST(MovingBody, GainsTheMomentumThatTheHandGives) {
  VirtualServo servo(way({0.01, 0, 0.05}, {0.01, 0, 0.0}, 0.5), kConfig, sceneOf(1, {floatingBox()}));
  Vec3 given(0);
  int touched = 0;
  for (int i = 0; i < 1000; ++i) {
    const TelemetrySample sample = servo.step();
    given -= 1e-3 * sample.force.contact;
    touched += sample.object != 0 ? 1 : 0;
  }
  EXPECT_GT(touched, 20);
  EXPECT_LT(bodyState(servo).momentum_Ns.z, -0.01);
  EXPECT_LT(glm::distance(bodyState(servo).momentum_Ns, given), 1e-9);
  EXPECT_GT(bodyState(servo).angularMomentum_Nms.y, 0) << "pushed beside its centre";
}

TEST(MovingBody, OutlivesAForceThatIsNoNumber) {
  ServoObject box = floatingBox();
  box.stiffness_N_per_m = std::numeric_limits<double>::quiet_NaN();
  VirtualServo servo(way({0.01, 0, 0.05}, {0.01, 0, 0.0}, 0.5), kConfig, sceneOf(1, {box}));
  bool isFaulty = false;
  for (int i = 0; i < 1000; ++i) isFaulty = servo.step().fault == Fault::kNonFiniteForce || isFaulty;
  EXPECT_TRUE(isFaulty);
  EXPECT_FALSE(isStopped(bodyState(servo).condition));
  EXPECT_TRUE(isFinite(bodyState(servo).momentum_Ns));
}

TEST(MovingBody, IsNeverEnteredByTheIhipWhileItTumbles) {
  VirtualServo servo(
      [](std::uint64_t tick) {
        const double t = 1e-3 * static_cast<double>(tick);
        return Vec3(0.02 * std::sin(9 * t), 0.02 * std::cos(7 * t), 0.033 + 0.03 * std::cos(5 * t));
      },
      kConfig);
  RigidBody body = floatingBody(boxMesh(Vec3(0.06)));
  body.spring = {50, 0.2, 0.05, 1e-4};
  ServoObject box = floatingBox();
  box.motion = std::make_shared<RigidBody>(body);
  servo.adopt(sceneOf(1, {box}));
  double deepest = 0;
  int touched = 0;
  for (int i = 0; i < 20'000; ++i) {
    const TelemetrySample sample = servo.step();
    ASSERT_TRUE(isFinite(sample.force.written));
    const Vec3 local = servo.state().bodies[0].frame.toLocal(sample.ihip);
    deepest = std::max(deepest, 0.03 - std::max({std::abs(local.x), std::abs(local.y), std::abs(local.z)}));
    touched += sample.object != 0 ? 1 : 0;
  }
  EXPECT_GT(touched, 1000);
  EXPECT_LT(deepest, 1e-6);
}

TEST(MovingBody, DroppedOnAStillHandIsFeltAndHeld) {
  ServoObject box = floatingBox({0, 0, 0.05});
  RigidBody heavy = *box.motion;
  heavy.gravity_m_per_s2 = {0, 0, -9.81};
  heavy.linearDamping_per_s = 5;
  heavy.freedom = Freedom::kSlider;
  heavy.joint.axis = {0, 0, 1};
  box.motion = std::make_shared<RigidBody>(heavy);
  VirtualServo servo(way(Vec3(0), Vec3(0), 1), kConfig, sceneOf(1, {box}));
  const TelemetrySample sample = servo.run(8000);
  EXPECT_EQ(sample.object, 1U);
  EXPECT_NEAR(sample.force.contact.z, -kMass_kg * 9.81, 0.01 * kMass_kg * 9.81);
}

TEST(MovingBody, IsDraggedByFriction) {
  const TriMesh mesh = boxMesh({0.1, 0.1, 0.02});
  RigidBody body = floatingBody(mesh);
  body.gravity_m_per_s2 = {0, 0, -9.81};
  body.planes[0] = {{0, 0, 1}, 0, 0.01};
  body.planeCount = 1;
  for (const bool rough : {false, true}) {
    ServoObject plate = moving(objectOf(1, surfaceOf(mesh), {0, 0, 0.01}), body);
    if (rough) plate = with(plate, friction(0.8, 0.6));
    VirtualServo servo(
        [](std::uint64_t tick) {
          const double t = 1e-3 * static_cast<double>(tick);
          return Vec3(0.03 * std::clamp(t - 1, 0.0, 1.0), 0, std::max(0.018, 0.03 - 0.02 * t));
        },
        kConfig, sceneOf(1, {plate}));
    servo.run(2100);
    const double x = servo.state().bodies[0].current.position.x;
    if (rough) {
      EXPECT_NEAR(x, 0.03, 0.005);
    } else {
      EXPECT_LT(std::abs(x), 1e-4);
    }
  }
}

TEST(MovingBody, OnAHingeOpensLikeADoor) {
  const TriMesh mesh = boxMesh({0.2, 0.01, 0.3});
  RigidBody door = floatingBody(mesh);
  door.freedom = Freedom::kHinge;
  door.joint = {{-0.1, 0, 0}, {0, 0, 1}, 0, 1.5};
  door.angularDamping_per_s = 1;
  VirtualServo servo(way({0.08, -0.02, 0}, {0.08, 0.04, 0}, 0.5), kConfig,
                     sceneOf(1, {moving(objectOf(1, surfaceOf(mesh), Vec3(0)), door)}));
  servo.run(600);
  EXPECT_GT(bodyState(servo).coordinate, 0.15);
  const Vec3 onAxis(-0.1, 0, 0.1);
  EXPECT_LT(glm::distance(toWorld(servo.state().bodies[0].current, onAxis), onAxis), 1e-12);
}

TEST(MovingBody, GoesOnThroughEditsOfOthersAndIsResetByAnEditOfItsPose) {
  VirtualServo servo(way({0, 0, 0.05}, {0, 0, 0.02}, 0.3), kConfig);
  const ServoObject box = floatingBox();
  servo.adopt(sceneOf(1, {box}));
  servo.run(320);
  const RigidState before = bodyState(servo);
  ASSERT_LT(before.momentum_Ns.z, -1e-3);
  const Pose there = servo.state().bodies[0].current;
  servo.adopt(sceneOf(2, {box, slab(2, {0.5, 0, 0})}));
  EXPECT_EQ(bodyState(servo).momentum_Ns, before.momentum_Ns);
  EXPECT_EQ(servo.state().bodies[0].current, there);

  ServoObject put = box;
  put.pose.position = {0.5, 0.5, 0.5};
  servo.adopt(sceneOf(3, {put, slab(2, {0.5, 0, 0})}));
  for (int i = 0; i < 1000 && !servo.adopted(); ++i) servo.step();
  servo.run(500);
  EXPECT_EQ(bodyState(servo).momentum_Ns, Vec3(0));
  EXPECT_EQ(servo.state().bodies[0].current.position, put.pose.position);
}

TEST(MovingBody, StartsAnewWhenItsPoseIsSetToTheSame) {
  VirtualServo servo(way({0, 0, 0.05}, {0, 0, 0.02}, 0.3), kConfig);
  ServoObject box = floatingBox();
  servo.adopt(sceneOf(1, {box}));
  servo.run(3000);
  ASSERT_LT(servo.state().bodies[0].current.position.z, -0.01);
  box.poseRevision = 2;
  servo.adopt(sceneOf(2, {box}));
  for (int i = 0; i < 2000 && !servo.adopted(); ++i) servo.step();
  EXPECT_EQ(bodyState(servo).momentum_Ns, Vec3(0));
  EXPECT_EQ(servo.state().bodies[0].current, box.pose);
}

TEST(MovingBody, ThatLeavesTheWorldIsStoppedNamedAndFadesFromUnderTheHand) {
  ServoObject box = floatingBox();
  const double edge = kWorldRadius_m - 0.001;
  box.pose.position.x = edge;
  RigidBody slow = *box.motion;
  slow.linearDamping_per_s = 100;  // it stays with the hand, whose way alone adds less than fades
  box.motion = std::make_shared<RigidBody>(slow);
  VirtualServo servo(way({edge - 0.044, 0, 0}, {edge - 0.02, 0, 0}, 1), kConfig, sceneOf(1, {box}));
  MotionState motion;
  double last_N = 0;
  int stopped = 0;
  for (int i = 0; i < 2000; ++i) {
    const double force_N = glm::length(servo.step().force.written);
    (void)updateMotionState(servo.state(), servo.tick(), motion);
    if (motion.body[0].condition == BodyCondition::kOutOfBounds && stopped++ > 2) {
      EXPECT_LE(force_N, last_N);
      EXPECT_LE(last_N - force_N, 0.035) << "much more than 30 N/s";
    }
    last_N = force_N;
  }
  EXPECT_GT(stopped, 900);
  EXPECT_EQ(last_N, 0);

  box.pose.position.x = 0.5;
  box.poseRevision = 2;
  servo.adopt(sceneOf(2, {box}));
  servo.run(10);
  EXPECT_TRUE(updateMotionState(servo.state(), servo.tick(), motion));
  EXPECT_LT(glm::distance(motion.body[0].pose.position, box.pose.position), 1e-15);
  EXPECT_FALSE(isStopped(motion.body[0].condition));
  EXPECT_FALSE(servo.state().bodies[0].pendingRemoval);
}

TEST(MovingBody, MovesInTurnWithOthersWhereTheAllowanceIsShort) {
  constexpr std::size_t kBodies = 8;
  constexpr double kTwoBodies = 2 * 2 * 1200;  // units of which half moves two of them
  constexpr int kTicks = 200;
  StepConfig config = kConfig;
  config.work_per_s = kTwoBodies / config.period_s;
  VirtualServo servo(way({0, 0, 1}, {0, 0, 1}, 1), config);
  std::vector<ServoObject> objects;
  for (std::size_t i = 0; i < kBodies; ++i) {
    ServoObject box = floatingBox({0.1 * static_cast<double>(i), 0, 0}, i + 1);
    RigidBody falling = *box.motion;
    falling.gravity_m_per_s2 = {0, 0, -9.81};
    box.motion = std::make_shared<RigidBody>(falling);
    objects.push_back(box);
  }
  servo.adopt(sceneOf(1, objects));
  for (int tick = 0; tick < kTicks; ++tick) {
    servo.step();
    std::size_t moved = 0;
    for (std::size_t i = 0; i < kBodies; ++i) moved += servo.state().moving[i].moved ? 1 : 0;
    ASSERT_GE(moved, 1U);
    ASSERT_LE(moved, 3U);
  }
  const double fallen_m = 9.81 * 0.2 * 0.2 / 2;
  for (std::size_t i = 0; i < kBodies; ++i) {
    EXPECT_NEAR(bodyState(servo, i).centre_m.z, -fallen_m, 9.81 * 0.2 * 0.01) << "body " << i;
  }
}

TEST(MovingBody, IsPushedForATickAloneAfterItHasWaitedForOthers) {
  constexpr std::size_t kBodies = 16;
  StepConfig config = kConfig;
  config.work_per_s = 4 * 2 * 1200 / config.period_s;  // units of which half moves a few of them
  Vec3 hand{0.5, 0, 0.05};
  VirtualServo servo([&](std::uint64_t) { return hand; }, config);
  std::vector<ServoObject> objects;
  for (std::size_t i = 0; i < kBodies; ++i) {
    ServoObject box = floatingBox({0.1 * static_cast<double>(i), 0, 0}, i + 1);
    RigidBody turning = *box.motion;
    turning.gravity_m_per_s2 = {0, 1e-3, 0};  // they stay awake, and where they are
    box.motion = std::make_shared<RigidBody>(turning);
    objects.push_back(box);
  }
  servo.adopt(sceneOf(1, objects));
  constexpr std::size_t kTouched = 5;
  for (int i = 0; i < 200 && servo.state().moving[kTouched].waited < 2; ++i) servo.step();
  ASSERT_GE(servo.state().moving[kTouched].waited, 2U);
  hand.z = 0.028;
  const Vec3 before = bodyState(servo, kTouched).momentum_Ns;
  const TelemetrySample pressed = servo.step();
  ASSERT_EQ(pressed.object, kTouched + 1);
  const Vec3 gained = bodyState(servo, kTouched).momentum_Ns - before;
  EXPECT_NEAR(gained.z, -1e-3 * pressed.force.contact.z, 1e-12);
}

TEST(MovingBody, IsDescribedWhereTheContactWasSolvedAndOnlyWhenItChanges) {
  VirtualServo servo(way({0, 0, 0.05}, {0, 0, 0.02}, 0.3), kConfig,
                     sceneOf(1, {slab(1, {0.5, 0, 0}), floatingBox(Vec3(0), 2)}));
  MotionState motion;
  servo.run(2);
  EXPECT_TRUE(updateMotionState(servo.state(), 2, motion));
  servo.run(50);
  EXPECT_FALSE(updateMotionState(servo.state(), 50, motion)) << "not pushed yet";
  servo.run(270);
  EXPECT_TRUE(updateMotionState(servo.state(), 320, motion));
  EXPECT_EQ(motion.tick, 320U);
  ASSERT_EQ(motion.bodyCount, 1U);
  EXPECT_EQ(motion.body[0].object, servo.state().objects[1].id);
  EXPECT_EQ(motion.body[0].pose, servo.state().bodies[1].current);
  servo.adopt(sceneOf(2, {slab(1, {0.5, 0, 0})}));
  servo.run(500);
  EXPECT_TRUE(updateMotionState(servo.state(), 900, motion)) << "it is gone";
  EXPECT_EQ(motion.bodyCount, 0U);
}

TEST(MovingBody, WhoseMotionIsTakenAwayGoesBackToWhereTheSceneHasIt) {
  VirtualServo servo(way({0, 0, 0.05}, {0, 0, 0.02}, 0.3), kConfig);
  ServoObject box = floatingBox();
  servo.adopt(sceneOf(1, {box}));
  servo.run(2000);
  ASSERT_LT(servo.state().bodies[0].current.position.z, -0.01);
  box.motion = nullptr;
  servo.adopt(sceneOf(2, {box}));
  servo.run(1000);
  EXPECT_EQ(servo.state().bodies[0].current, box.pose);
  EXPECT_EQ(servo.state().moving.count, 0U);
}

TEST(MovingBody, GoesOnInACopyOfTheStateBitForBit) {
  VirtualServo servo(way({0.02, 0.01, 0.05}, {0, 0, 0.0}, 0.4), kConfig, sceneOf(1, {floatingBox()}));
  servo.run(300);
  VirtualServo copy = servo;
  for (int i = 0; i < 500; ++i) {
    ASSERT_EQ(servo.step().force.written, copy.step().force.written);
    ASSERT_EQ(servo.state().bodies[0].current, copy.state().bodies[0].current);
  }
}

}  // namespace
}  // namespace haptics::fixture::moving_bodies_tests

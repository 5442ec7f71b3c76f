#include <gtest/gtest.h>

#include "common/mesh/generators.h"
#include "haptic_server/engine/collision/collision_points.h"
#include "haptic_server/engine/motion/solid.h"
#include "haptic_server/engine/step/moving_bodies.h"
#include "haptic_server/recording/state_image.h"
#include "tests/haptic_server/engine/step/surface_world.h"

namespace haptics::fixture::colliding_bodies_tests {
namespace {

const TriMesh kBrick = makeBox({0.06, 0.04, 0.03}, 1).value();
const StepConfig kConfig{.maxForce_N = 20};

/// A mass of 0 for one that stands still.
ServoObject colliding(std::uint64_t id, const TriMesh& mesh, Vec3 at, double mass_kg) {
  ServoObject object = objectOf(id, surfaceOf(mesh), at);
  object.collision = std::make_shared<const CollisionPoints>(makeCollisionPoints(*object.surface));
  if (mass_kg == 0) return object;
  const Solid solid = solidOf(mesh.vertices, mesh.triangles);
  RigidBody body;
  EXPECT_EQ(spreadMass(mass_kg, solid.centre, mass_kg / solid.volume_m3 * solid.inertia, body.mass), MassDefect::kNone);
  object.motion = std::make_shared<const RigidBody>(body);
  return object;
}

ServoObject table() { return colliding(1, makeBox({0.5, 0.5, 0.02}, 1).value(), {0, 0, -0.01}, 0); }
ServoObject brick(std::uint64_t id, Vec3 at) { return colliding(id, kBrick, at, 0.15); }

VirtualServo::Trajectory still(Vec3 place) {
  return [place](std::uint64_t) { return place; };
}
const RigidState& bodyState(const VirtualServo& servo, std::size_t i) { return servo.state().moving[i].state; }
Vec3 placeOf(const VirtualServo& servo, std::size_t body) { return servo.state().bodies[body].current.position; }
bool isAsleep(const VirtualServo& servo, std::size_t i) {
  return bodyState(servo, i).condition == BodyCondition::kAsleep;
}

TEST(CollidingBodies, AreMovedByTheHandThroughOneAnother) {
  const auto push = [](std::uint64_t tick) {
    return Vec3(-0.08 + 0.1 * std::min(1.0, static_cast<double>(tick) * 1e-3), 0, 0.012);
  };
  VirtualServo servo(push, kConfig, sceneOf(1, {table(), brick(2, {-0.03, 0, 0.015}), brick(3, {0.04, 0, 0.015})}));
  int pushed = 0;
  for (int i = 0; i < 1500; ++i) pushed += servo.step().object == 2 ? 1 : 0;
  EXPECT_GT(pushed, 100);
  EXPECT_NEAR(placeOf(servo, 2).x - placeOf(servo, 1).x, 0.06, 2e-4);
  EXPECT_GT(placeOf(servo, 2).x, 0.07);
  EXPECT_NEAR(placeOf(servo, 1).z, 0.015, 1e-4);
}

TEST(CollidingBodies, FallAsleepTogetherAndAreWokenByEditsOfWhatTheyLieOn) {
  const std::vector<ServoObject> objects{table(), brick(2, {0, 0, 0.015}), brick(3, {0.004, 0.003, 0.045})};
  VirtualServo servo(still({0, 0, 0.2}), kConfig, sceneOf(1, objects));
  servo.run(2000);
  EXPECT_TRUE(isAsleep(servo, 0) && isAsleep(servo, 1));
  const Vec3 upper = placeOf(servo, 2);

  std::vector<ServoObject> stiffer = objects;
  stiffer[2].stiffness_N_per_m *= 2;
  servo.adopt(sceneOf(2, stiffer));
  servo.run(10);
  EXPECT_TRUE(isAsleep(servo, 0) && isAsleep(servo, 1)) << "nothing that they lie on was edited";
  EXPECT_EQ(placeOf(servo, 2), upper);

  servo.adopt(sceneOf(3, {stiffer[0], stiffer[2]}));
  servo.run(2000);
  EXPECT_NEAR(placeOf(servo, 1).z, 0.015, 1e-4) << "it has fallen to where the lower one was";
  servo.adopt(sceneOf(4, {stiffer[2]}));
  servo.run(300);
  EXPECT_LT(placeOf(servo, 0).z, -0.1);
}

/// Drives the first object with a velocity, by a sample every so many ticks.
struct Drive {
  int period = 1;
  double first_s = 0;
};
void drive(
    VirtualServo& servo, const std::vector<ServoObject>& objects, Vec3 velocity, int ticks, Drive by = {},
    const std::function<void()>& eachTick = [] {}) {
  static std::uint64_t revision = 100;
  const Vec3 from = placeOf(servo, 0);
  for (int i = 0; i < ticks; ++i) {
    if (i % by.period == 0) {
      ++revision;
      auto scene = sceneOf(revision, objects);
      scene->kinematic.resize(objects.size());
      const Vec3 to = from + 1e-3 * (i + by.period) * velocity;
      scene->kinematic[0] = {revision, Pose{Quat(1, 0, 0, 0), to}, by.first_s};
      servo.adopt(std::move(scene));
    }
    servo.step();
    eachTick();
  }
}

TEST(CollidingBodies, RideOnWhatIsDrivenAndAreWokenByIt) {
  const std::vector<ServoObject> objects{table(), brick(2, {0, 0, 0.015})};
  VirtualServo servo(still({0, 0, 0.5}), kConfig, sceneOf(1, objects));
  servo.run(2000);
  ASSERT_TRUE(isAsleep(servo, 0));
  drive(servo, objects, {0, 0, 0.2}, 500, {}, [&] {
    ASSERT_NEAR(placeOf(servo, 1).z - placeOf(servo, 0).z, 0.025, 5e-4) << "it is lifted, and does not fly";
  });
  servo.run(300);  // it comes down from the stop
  EXPECT_NEAR(placeOf(servo, 1).z, 0.115, 5e-5);
  drive(servo, objects, {0.1, 0, 0}, 1000);
  EXPECT_NEAR(placeOf(servo, 1).x, placeOf(servo, 0).x, 3e-3) << "friction takes it along";
}

class CollidingBodiesOnAStream : public ::testing::TestWithParam<int> {};

TEST_P(CollidingBodiesOnAStream, AreNotThrownAsItBegins) {
  const std::vector<ServoObject> objects{table(), brick(2, {0, 0, 0.015})};
  VirtualServo servo(still({0, 0, 0.5}), kConfig, sceneOf(1, objects));
  servo.run(2000);
  drive(servo, objects, {0, 0, 0.2}, 480, {GetParam(), kFirstSample_s},
        [&] { ASSERT_NEAR(placeOf(servo, 1).z - placeOf(servo, 0).z, 0.025, 5e-4); });
  EXPECT_NEAR(placeOf(servo, 0).z, 0.086, 1e-9);
}
INSTANTIATE_TEST_SUITE_P(Periods, CollidingBodiesOnAStream, ::testing::Values(1, 2, 8, 16));

TEST(CollidingBodies, ArePushedByAWallThatIsDriven) {
  const std::vector<ServoObject> objects{colliding(1, makeBox({0.02, 0.1, 0.05}, 1).value(), {-0.1, 0, 0.026}, 0),
                                         colliding(2, makeBox({0.5, 0.5, 0.02}, 1).value(), {0, 0, -0.01}, 0),
                                         brick(3, {0, 0, 0.015})};
  VirtualServo servo(still({0, 0, 0.5}), kConfig, sceneOf(1, objects));
  servo.run(2000);
  ASSERT_TRUE(isAsleep(servo, 0));
  drive(servo, objects, {0.5, 0, 0}, 300, {},
        [&] { ASSERT_GT(placeOf(servo, 2).x - placeOf(servo, 0).x, 0.04 - 1e-4) << "nothing is passed through"; });
  EXPECT_GT(placeOf(servo, 2).x, 0.089);
}

TEST(CollidingBodies, LieOnASurfaceThatBendsAwayByALittleAtEachEdge) {
  const TriMesh ring = makeTorus(0.2, 0.08, 256, 128).value();
  VirtualServo servo(still({0, 0, 0.2}), kConfig,
                     sceneOf(1, {colliding(1, ring, {0, 0, 0}, 0), brick(2, {0.1992, 0, 0.0952})}));
  servo.run(500);
  EXPECT_NEAR(placeOf(servo, 1).z, 0.095, 2e-4);
}

TEST(CollidingBodies, PassThroughWhatDoesNotCollide) {
  ServoObject ground = table();
  ground.collision = nullptr;
  VirtualServo servo(still({0, 0, 0.2}), kConfig, sceneOf(1, {ground, brick(2, {0, 0, 0.015})}));
  servo.run(300);
  EXPECT_LT(placeOf(servo, 1).z, -0.2);
}

TEST(CollidingBodies, ThatAreEditedIntoOneAnotherComeApartSlowly) {
  VirtualServo servo(still({0, 0, 0.2}), kConfig,
                     sceneOf(1, {table(), brick(2, {0, 0, 0.015}), brick(3, {0.1, 0, 0.015})}));
  servo.run(1500);
  ServoObject moved = brick(3, {0.045, 0.002, 0.015});
  moved.poseRevision = 2;
  servo.adopt(sceneOf(2, {table(), brick(2, {0, 0, 0.015}), moved}));
  double fastest = 0;
  for (int i = 0; i < 1500; ++i) {
    const Vec3 before = placeOf(servo, 2);
    servo.step();
    if (i > 0) fastest = std::max(fastest, glm::distance(placeOf(servo, 2), before));
  }
  EXPECT_LT(fastest, 1.5e-4);
  EXPECT_GT(placeOf(servo, 2).x - placeOf(servo, 1).x, 0.0599);
}

TEST(CollidingBodies, WaitRatherThanPassThroughWhereTheAllowanceIsSmall) {
  StepConfig config = kConfig;
  config.work_per_s = 10e6;
  std::vector<ServoObject> objects{table()};
  const TriMesh marble = makeSphere(0.012, 24).value();
  for (std::uint64_t i = 0; i < 8; ++i)
    objects.push_back(colliding(
        i + 2, marble, {0.03 * static_cast<double>(i % 4), 0.001, 0.03 + 0.03 * static_cast<double>(i / 4)}, 0.02));
  VirtualServo servo(still({0, 0, 0.2}), config, sceneOf(1, objects));
  for (int i = 0; i < 20'000; ++i) {
    servo.step();
    for (std::size_t b = 1; b < objects.size(); ++b) ASSERT_GT(placeOf(servo, b).z, 0.0117) << i;
  }
  EXPECT_GT(servo.state().report.allowanceSpent, 50U);
  for (std::size_t b = 1; b < 5; ++b) EXPECT_LT(placeOf(servo, b).z, 0.0125) << "they get there all the same";
}

TEST(CollidingBodies, ThatWaitWhereTheContactDoesTooAreCountedOnce) {
  StepConfig config = kConfig;
  config.work_per_s = 1e6;
  const TriMesh marble = makeSphere(0.012, 24).value();
  std::vector<ServoObject> objects{table()};
  for (std::uint64_t i = 0; i < 4; ++i)
    objects.push_back(
        colliding(i + 2, marble, {0.023 * static_cast<double>(i % 2), 0, 0.02 + 0.02 * static_cast<double>(i)}, 0.02));
  const auto shake = [](std::uint64_t tick) { return Vec3(0.02 * std::sin(0.5 * static_cast<double>(tick)), 0, 0.01); };
  VirtualServo servo(shake, config, sceneOf(1, objects));
  std::uint64_t before = 0, both = 0;
  for (int i = 0; i < 2000; ++i) {
    servo.step();
    const std::uint64_t more =
        servo.state().report.allowanceSpent - std::exchange(before, servo.state().report.allowanceSpent);
    ASSERT_LE(more, 1U) << i;
    both += more;
  }
  EXPECT_GT(both, 100U);
}

TEST(CollidingBodies, GoOnFromAnImageBitForBit) {
  const std::shared_ptr<const ServoScene> scene =
      sceneOf(1, {table(), brick(2, {0, 0, 0.03}), brick(3, {0.03, 0.01, 0.065})});
  VirtualServo servo(still({0, 0, 0.2}), kConfig, scene);
  servo.run(150);
  auto state = stateFrom(stateImage(servo.state()), *scene, kConfig).value();
  servo.run(300);
  for (int i = 0; i < 300; ++i) {
    const DeviceReading reading{Vec3(0, 0, 0.2), DeviceState::kReady, {}};
    static_cast<void>(hapticStep(*scene, *state, kConfig, {static_cast<std::uint64_t>(150 + i), 0, reading}));
  }
  for (std::size_t b = 1; b < 3; ++b) EXPECT_EQ(state->bodies[b].current, servo.state().bodies[b].current);
}

}  // namespace
}  // namespace haptics::fixture::colliding_bodies_tests

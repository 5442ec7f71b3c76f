#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "common/maths/rotation.h"
#include "common/mesh/generators.h"
#include "haptic_server/engine/motion/coupling.h"
#include "haptic_server/engine/motion/solid.h"
#include "haptic_server/engine/motion/support_points.h"
#include "haptic_server/engine/step/grasp.h"
#include "haptic_server/engine/step/tool_step.h"
#include "tests/haptic_server/engine/step/surface_world.h"

namespace haptics::fixture::grasp_tests {
namespace {

constexpr double kRadius_m = 0.05;
/// 30 N/s: what an edit may do too.
constexpr double kMaxStep_N = 0.03 + 1e-4;  // the brick moves a little by itself
const StepConfig kConfig{.maxForce_N = 8, .rotation = {.radius_m = kRadius_m, .maxTorque_Nm = 0.2}};
const TriMesh kBrick = makeBox({0.06, 0.04, 0.03}, 1).value();

RigidBody heavy(double mass_kg) {
  const Solid solid = solidOf(kBrick.vertices, kBrick.triangles);
  RigidBody body;
  EXPECT_EQ(spreadMass(mass_kg, solid.centre, mass_kg / solid.volume_m3 * solid.inertia, body.mass), MassDefect::kNone);
  body.setSupport(supportPoints(kBrick.vertices));
  body.planes[0] = {};
  body.planeCount = 1;
  return body;
}

ServoObject moving(const RigidBody& body, Vec3 at = {0, 0, 0.015}, std::uint64_t id = 1) {
  ServoObject object = objectOf(id, surfaceOf(kBrick), at);
  const GraspSprings grasp =
      graspSprings(body, minApparentMass_kg(body, kBrick.vertices), object.stiffness_N_per_m, kConfig.period_s, 1);
  object.torsion_Nm_per_rad = grasp.torsion_Nm_per_rad;
  object.graspDamping_Ns_per_m = grasp.damping_Ns_per_m;
  object.motion = std::make_shared<const RigidBody>(body);
  return object;
}

/// On a table at z = 0.
ServoObject brick(double mass_kg = 0.1) { return moving(heavy(mass_kg)); }

/// A hand on a device that turns and has a button, which it goes on holding as it was.
class Hand {
 public:
  explicit Hand(std::vector<ServoObject> objects) : servo({}, kConfig, sceneOf(1, std::move(objects))) {
    reading.position = {0.01, 0.006, 0.05};
    reading.state = DeviceState::kReady;
    (void)step();
  }
  TelemetrySample step() {
    const Vec3 force = sample.force.written, torque = torque_Nm;
    sample = servo.stepWith(reading);
    torque_Nm = writtenTorque_Nm(servo.state());
    EXPECT_TRUE(isFinite(sample.force.written) && isFinite(torque_Nm));
    largestStep_N = std::max(
        {largestStep_N, glm::distance(force, sample.force.written), glm::distance(torque, torque_Nm) / kRadius_m});
    return sample;
  }
  /// The largest step of the force, and of the torque on its radius, N.
  double rest(int ticks) {
    largestStep_N = 0;
    for (int i = 0; i < ticks; ++i) (void)step();
    return largestStep_N;
  }
  void moveTo(Vec3 to, double speed_m_per_s = 0.1, Vec3 turn_rad = Vec3(0)) {
    const Vec3 from = reading.position;
    const Quat turned = reading.rotation;
    const int ticks = 1 + static_cast<int>(glm::distance(from, to) / (speed_m_per_s * kConfig.period_s));
    for (int i = 1; i <= ticks; ++i) {
      const double part = (1 - std::cos(std::numbers::pi * i / ticks)) / 2;
      reading.position = glm::mix(from, to, part);
      reading.rotation = rotationBy(part * turn_rad) * turned;
      (void)step();
    }
  }
  void press(bool pressed) { reading.status.set(HandAction::kGrasp, pressed); }
  [[nodiscard]] const RigidState& body(std::size_t i = 0) const { return servo.state().moving[i].state; }

  VirtualServo servo;
  DeviceReading reading;
  TelemetrySample sample;
  Vec3 torque_Nm{0};
  double largestStep_N = 0;
};

/// Its finger on top of the brick, pressing 1 N.
void touch(Hand& hand) {
  hand.moveTo({0.01, 0.006, 0.03 - 1.0 / kStiffness});
  (void)hand.rest(300);
  ASSERT_EQ(hand.sample.object, 1U);
}

/// Stored by the coupling, J.
double storedIn(const Hand& hand, const ServoObject& object) {
  const HapticState& state = hand.servo.state();
  const Body& body = state.bodies[0];
  const Quat off = body.current.rotation * glm::conjugate(hand.reading.rotation * state.grasp.turned);
  return object.stiffness_N_per_m / 2 * squaredLength(toWorld(body.current, state.grasp.place) - hand.sample.hip) +
         2 * object.torsion_Nm_per_rad * squaredLength(Vec3(off.x, off.y, off.z));
}

/// Lost in its dampers in the tick just made, J.
double lostIn(const Hand& hand, const ServoObject& object, Vec3 handWay, Quat turnedBefore) {
  const HapticState& state = hand.servo.state();
  const Body& body = state.bodies[0];
  const double period_s = kConfig.period_s;
  const Vec3 way = toWorld(body.current, state.grasp.place) - toWorld(body.previous, state.grasp.place) - handWay;
  const Vec3 turn = rotationVector(body.current.rotation * glm::conjugate(body.previous.rotation)) -
                    rotationVector(hand.reading.rotation * glm::conjugate(turnedBefore));
  const Vec3 moments = object.motion->mass.moments;
  const double damper = std::sqrt(object.torsion_Nm_per_rad * std::min({moments.x, moments.y, moments.z}));
  return (object.graspDamping_Ns_per_m * squaredLength(way) + damper * squaredLength(turn)) / period_s;
}

TEST(Grasp, LiftsAndTurnsABrickForAMinuteAndItsEnergyIsAccountedFor) {
  const ServoObject object = brick();
  Hand hand({object});
  touch(hand);
  hand.press(true);
  EXPECT_LE(hand.rest(100), kMaxStep_N);
  EXPECT_EQ(hand.sample.grasped, 1U);
  hand.moveTo({0.01, 0.006, 0.12});
  (void)hand.rest(500);
  EXPECT_NEAR(hand.sample.force.written.z, -0.1 * 9.81, 0.01) << "its weight";

  const auto energy_J = [&] { return energyOf(*object.motion, hand.body()) + storedIn(hand, object); };
  const auto byEdits_J = [&] { return hand.sample.energyGiven_J[static_cast<std::size_t>(EnergyFeature::kEdit)]; };
  const double before_J = energy_J() - byEdits_J();
  double given_J = 0, lost_J = 0, moved_J = 0, farthest_J = 0;
  const Vec3 middle = hand.reading.position;
  for (int i = 1; i <= 60'000; ++i) {
    const double t = i * kConfig.period_s, begins = std::min(1.0, t), ends = std::clamp(60 - t, 0.0, 1.0);
    const Vec3 position = hand.reading.position, force = hand.sample.force.written, torque = hand.torque_Nm;
    const Quat rotation = hand.reading.rotation;
    hand.reading.position =
        middle + begins * ends * Vec3(0.03 * std::sin(3 * t), 0.02 * std::sin(2 * t), 0.04 * std::sin(t));
    hand.reading.rotation =
        rotationBy(begins * ends * Vec3(0.8 * std::sin(1.5 * t), 0.6 * std::sin(t), 1.5 * std::sin(0.7 * t)));
    (void)hand.step();
    const Vec3 way = hand.reading.position - position;
    const double given =
        glm::dot(force, way) + glm::dot(torque, rotationVector(hand.reading.rotation * glm::conjugate(rotation)));
    given_J += given;
    moved_J += std::abs(given);
    lost_J += lostIn(hand, object, way, rotation);
    farthest_J = std::max(farthest_J, std::abs(energy_J() - byEdits_J() + given_J + lost_J - before_J));
  }
  EXPECT_EQ(hand.sample.grasped, 1U);
  EXPECT_GT(moved_J, 1);
  EXPECT_LT(farthest_J, 1e-3);

  (void)hand.rest(500);
  hand.press(false);
  EXPECT_LE(hand.rest(50), kMaxStep_N);
  EXPECT_EQ(hand.sample.grasped, 0U);
  (void)hand.rest(1000);
  EXPECT_EQ(hand.sample.force.written, Vec3(0));
  EXPECT_LT(hand.body().centre_m.z, 0.04) << "it has fallen";
}

/// Taken and let go anywhere, in friction, pressed, hanging and turned: the hand rests while the button moves.
TEST(Grasp, TakesAndLetsGoWithoutAStep) {
  ServoObject rough = with(brick(0.2), friction(0.8, 0.5));
  Hand hand({rough});
  std::mt19937 random(3);
  const auto any = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
  int taken = 0, rubbing = 0, hanging = 0;
  for (int i = 0; i < 1000; ++i) {
    const Pose at = hand.servo.state().bodies[0].current;
    hand.reading.rotation = rotationBy(0.3 * Vec3(any(), any(), any()));
    hand.moveTo(at.position + Vec3(0.02 * any(), 0.01 * any(), 0.02), 0.5);
    hand.moveTo(at.position + Vec3(0.005 * any(), 0.005 * any(), 0.0145 - 0.0015 * (1 + any())), 0.2);
    (void)hand.rest(100);
    rubbing += glm::length(hand.sample.force.friction) > 0.1;
    hand.press(true);
    EXPECT_LE(hand.rest(90), kMaxStep_N) << i;
    taken += hand.sample.grasped == 1;
    if (i % 2 == 0) {
      hand.moveTo(hand.reading.position + Vec3(0.01 * any(), 0.01 * any(), 0.01 + 0.01 * any()), 0.1,
                  0.1 * Vec3(any(), any(), any()));
      (void)hand.rest(300);
      hanging += hand.sample.force.written.z < -1;
    }
    hand.press(false);
    for (int k = 0; k < 100 && (k == 0 || hand.sample.object == 0); ++k) {  // until the brick falls against the finger
      if (const double step_N = hand.rest(1); k == 0 || hand.sample.object == 0) {
        EXPECT_LE(step_N, kMaxStep_N) << i;
      }
    }
    hand.moveTo(hand.reading.position + Vec3(0, 0, 0.03), 0.5);
    (void)hand.rest(300);  // it falls and comes to rest
    if (testing::Test::HasFailure()) break;
  }
  EXPECT_GT(taken, 800);
  EXPECT_GT(rubbing, 100);
  EXPECT_GT(hanging, 300);
}

TEST(Grasp, PullsADoorOpen) {
  RigidBody door = heavy(0.2);
  door.planeCount = 0;
  door.freedom = Freedom::kHinge;
  door.joint = {{-0.03, 0, 0}, {0, 0, 1}, 0, 1.5};
  Hand hand({moving(door, Vec3(0))});
  hand.reading.position.y = 0.05;
  hand.moveTo({0.02, 0.03, 0});
  hand.moveTo({0.02, 0.0195, 0});
  (void)hand.rest(100);
  ASSERT_EQ(hand.sample.object, 1U) << "the side at +y, to which it opens";
  ASSERT_LT(hand.body().coordinate, 1e-9);
  hand.press(true);
  (void)hand.rest(100);
  hand.moveTo({0.015, 0.045, 0});
  EXPECT_GT(hand.body().coordinate, 0.2);
  const double open = hand.body().coordinate;
  hand.moveTo({0.02, 0.021, 0});
  (void)hand.rest(200);
  EXPECT_LT(hand.body().coordinate, open / 4) << "and closes it by pushing";
}

TEST(Grasp, HoldsNothingThatItDidNotTouchOnPressingOrThatStandsStill) {
  Hand hand({brick(), slab(2, {0.2, 0, 0})});
  hand.press(true);
  touch(hand);
  EXPECT_EQ(hand.sample.grasped, 0U);
  hand.press(false);
  (void)hand.rest(5);
  hand.press(true);
  (void)hand.rest(5);
  EXPECT_EQ(hand.sample.grasped, 1U);
  hand.press(false);
  hand.moveTo({0.2, 0, 0.1});
  hand.moveTo({0.2, 0, 0.049});
  ASSERT_EQ(hand.sample.object, 2U);
  hand.press(true);
  (void)hand.rest(5);
  EXPECT_EQ(hand.sample.grasped, 0U);
}

TEST(Grasp, LastsThroughEditsOfOthersAndEndsWithItsBodyWithoutAStep) {
  const ServoObject object = brick(), other = slab(2, {0.5, 0, 0});
  ServoObject put = object;
  put.pose.position.x = 0.3;
  put.poseRevision = 2;
  ServoObject still = object;
  still.motion = nullptr;
  const std::vector<std::vector<ServoObject>> ends{{put}, {other}, {still}};
  for (const std::vector<ServoObject>& end : ends) {
    Hand hand({object});
    touch(hand);
    hand.press(true);
    hand.moveTo({0.01, 0.006, 0.08});
    (void)hand.rest(300);
    hand.servo.adopt(sceneOf(2, {slab(0, {0, 0.5, 0}), object, other}));
    EXPECT_LE(hand.rest(50), kMaxStep_N);
    EXPECT_EQ(hand.sample.grasped, 1U);
    hand.servo.adopt(sceneOf(3, end));
    EXPECT_LE(hand.rest(300), kMaxStep_N);
    EXPECT_EQ(hand.sample.grasped, 0U);
    EXPECT_EQ(hand.sample.force.written, Vec3(0));
  }
}

TEST(Grasp, EndsWithAFaultAndBeginsOnlyByAnotherPress) {
  Hand hand({brick()});
  touch(hand);
  hand.press(true);
  (void)hand.rest(50);
  ASSERT_EQ(hand.sample.grasped, 1U);
  hand.reading.state = DeviceState::kHoming;
  (void)hand.rest(30);
  EXPECT_EQ(hand.sample.grasped, 0U);
  EXPECT_EQ(hand.sample.force.written, Vec3(0));
  hand.reading.state = DeviceState::kReady;
  hand.moveTo({0.01, 0.006, 0.05});
  touch(hand);
  EXPECT_EQ(hand.sample.grasped, 0U);
  hand.press(false);
  (void)hand.rest(5);
  hand.press(true);
  (void)hand.rest(5);
  EXPECT_EQ(hand.sample.grasped, 1U);
}

/// Of a device that gives less than the brick weighs: the coupling bears what the hand feels, and no more.
TEST(Grasp, IsBoundedByTheDevice) {
  Hand hand({brick(2)});
  touch(hand);
  hand.press(true);
  hand.moveTo({0.01, 0.006, 0.1});
  (void)hand.rest(500);
  EXPECT_EQ(hand.sample.grasped, 1U);
  EXPECT_NEAR(glm::length(hand.sample.force.written), kConfig.maxForce_N, 1e-6);
  EXPECT_LT(hand.body().centre_m.z, 0.016);
}

TEST(Grasp, GoesOnInACopyOfTheStateBitForBit) {
  Hand hand({brick()});
  touch(hand);
  hand.press(true);
  hand.moveTo({0.01, 0.006, 0.06});
  Hand copy = hand;
  for (int i = 0; i < 500; ++i) {
    hand.reading.rotation = copy.reading.rotation = rotationBy({1e-3 * i, 0, 2e-3 * i});
    hand.press(i < 400);
    copy.press(i < 400);
    ASSERT_EQ(hand.step().force.written, copy.step().force.written) << i;
    ASSERT_EQ(hand.torque_Nm, copy.torque_Nm) << i;
    ASSERT_EQ(hand.body().centre_m, copy.body().centre_m) << i;
  }
}

}  // namespace
}  // namespace haptics::fixture::grasp_tests

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "common/maths/rotation.h"
#include "common/mesh/generators.h"
#include "haptic_server/engine/collision/collision_points.h"
#include "haptic_server/engine/geometry/spaced_points.h"
#include "haptic_server/engine/motion/solid.h"
#include "haptic_server/engine/step/moving_bodies.h"
#include "haptic_server/engine/step/tool_step.h"
#include "haptic_server/recording/state_image.h"
#include "haptic_server/servo/allocation_tripwire.h"
#include "tests/haptic_server/engine/step/virtual_servo.h"

namespace haptics::fixture::held_tool_tests {
namespace {

constexpr double kSpacing_m = 0.004;
constexpr double kStiffness_N_per_m = 800;
const StepConfig kConfig{.maxForce_N = 20};
const TriMesh kBar = makeBox({0.04, 0.02, 0.01}, 2).value();

ServoObject toolOf(std::uint64_t id, const TriMesh& mesh, double spacing_m = kSpacing_m,
                   const Quat& turned = {1, 0, 0, 0}) {
  ServoObject object = objectOf(id, surfaceOf(mesh), {}, kStiffness_N_per_m);
  object.pose.rotation = turned;
  object.tool = std::make_shared<const Tool>(Tool{object.surface, makeToolShell(*object.surface, spacing_m).value()});
  object.torsion_Nm_per_rad = 1;
  return object;
}

ServoObject obstacle(std::uint64_t id, const TriMesh& mesh, Vec3 at) {
  ServoObject object = objectOf(id, surfaceOf(mesh), at);
  object.sharp = std::make_shared<const std::vector<Vec3>>(sharpPoints(*object.surface, kSpacing_m, kMaxToolPoints));
  return object;
}

/// Its top is z = 0.
ServoObject floorOf(std::uint64_t id) { return obstacle(id, makeBox({0.4, 0.4, 0.1}, 4).value(), {0, 0, -0.05}); }

ServoObject brick(std::uint64_t id, Vec3 at, double mass_kg) {
  const TriMesh mesh = makeBox({0.06, 0.04, 0.03}, 1).value();
  ServoObject object = obstacle(id, mesh, at);
  const Solid solid = solidOf(mesh.vertices, mesh.triangles);
  RigidBody body;
  EXPECT_EQ(spreadMass(mass_kg, solid.centre, mass_kg / solid.volume_m3 * solid.inertia, body.mass), MassDefect::kNone);
  body.gravity_m_per_s2 = Vec3(0);
  object.motion = std::make_shared<const RigidBody>(body);
  return object;
}

VirtualServo::Trajectory path(Vec3 from, Vec3 to, double seconds) {
  return [=](std::uint64_t tick) {
    return from + std::min(1.0, 1e-3 * static_cast<double>(tick) / seconds) * (to - from);
  };
}

Pose proxyOf(const VirtualServo& servo, std::size_t tool) { return servo.state().bodies[tool].current; }

void expectSame(const TelemetrySample& a, const TelemetrySample& b, int tick) {
  ASSERT_EQ(a.force.written, b.force.written) << tick;
  ASSERT_EQ(a.ihip, b.ihip) << tick;
  ASSERT_EQ(a.object, b.object) << tick;
}

TEST(HeldTool, PressesWithItsFace) {
  VirtualServo servo(path({0, 0, 0.02}, {0.01, 0, 0.002}, 0.4), kConfig, sceneOf(1, {floorOf(1), toolOf(2, kBar)}));
  const TelemetrySample sample = servo.run(600);
  EXPECT_EQ(sample.object, 1U);
  EXPECT_NEAR(proxyOf(servo, 1).position.z, 0.005, 1e-6);
  EXPECT_NEAR(sample.force.written.z, kStiffness_N_per_m * 0.003, 1e-2);
  EXPECT_NEAR(sample.surfaceNormal.z, 1, 1e-9);
  MotionState motion;
  EXPECT_TRUE(updateMotionState(servo.state(), 1, motion));
  ASSERT_EQ(motion.bodyCount, 1U);
  EXPECT_EQ(motion.body[0].object, 2U);
  EXPECT_EQ(motion.body[0].pose, proxyOf(servo, 1));
  EXPECT_EQ(motion.tool.object, 2U);
  Vec3 sum(0);
  for (const ToolState::Point& point : motion.tool.points()) sum += point.force_N;
  EXPECT_NEAR(glm::distance(sum, sample.force.spring), 0, 1e-3);
}

TEST(HeldTool, IsTurnedAsTheSceneHasIt) {
  const Quat upright = glm::angleAxis(std::numbers::pi / 2, Vec3(0, 1, 0));
  VirtualServo servo(path({0, 0, 0.04}, {0, 0, 0.012}, 0.4), kConfig,
                     sceneOf(1, {floorOf(1), toolOf(2, kBar, kSpacing_m, upright)}));
  servo.run(600);
  EXPECT_NEAR(proxyOf(servo, 1).position.z, 0.02, 1e-5);
}

TEST(HeldTool, PushesWhatMovesAndGivesItItsTorque) {
  VirtualServo servo(path({-0.08, 0.015, 0.1}, {-0.02, 0.015, 0.1}, 0.3), kConfig,
                     sceneOf(1, {brick(1, {0, 0, 0.1}, 0.1), toolOf(2, makeBox({0.02, 0.02, 0.02}, 2).value())}));
  servo.run(300);
  const RigidState& state = servo.state().moving[0].state;
  EXPECT_GT(state.momentum_Ns.x, 0.005);
  EXPECT_LT(state.angularMomentum_Nms.z, -1e-5) << "pushed on the side of +y, it turns about -z";
}

/// One of three: the others are where the scene has them, and are not felt.
TEST(HeldTool, IsTheNextAtEachPressOfItsButtonWithoutAStep) {
  ServoObject bar = toolOf(2, kBar), cube = toolOf(3, makeBox({0.02, 0.02, 0.02}, 2).value()), ball = toolOf(5, kBar);
  bar.pose.position = {0, 0.1, 0.005};
  cube.pose.position = {0, 0, 0.008};  // where the hand is
  ball.pose.position = {0, -0.1, 0.005};
  VirtualServo servo(path({0, 0, 0.03}, {0, 0, 0.004}, 0.3), kConfig, sceneOf(1, {floorOf(1), bar, cube, ball}));
  TelemetrySample sample = servo.run(400);
  EXPECT_EQ(servo.state().tool.body, 1U);
  EXPECT_NEAR(sample.force.written.z, kStiffness_N_per_m * 0.001, 1e-2);
  double largest_N = 0;
  const auto hold = [&](bool pressed, int ticks) {
    const std::uint64_t allocations = AllocationTripwire::count();
    for (int i = 0; i < ticks; ++i) {
      DeviceReading reading{{.position = {0, 0, 0.004}, .state = DeviceState::kReady}};
      reading.status.set(HandAction::kNextTool, pressed);
      const Vec3 before = sample.force.written;
      const AllocationTripwire armed;
      sample = servo.stepWith(reading);
      largest_N = std::max(largest_N, glm::distance(sample.force.written, before));
    }
    EXPECT_EQ(AllocationTripwire::count(), allocations);
  };
  MotionState motion;
  (void)updateMotionState(servo.state(), 1, motion);
  for (const std::uint64_t next : {3U, 5U, 2U, 3U}) {
    hold(true, 300);
    EXPECT_TRUE(updateMotionState(servo.state(), 1, motion));
    EXPECT_EQ(motion.tool.object, next);
    for (const BodyState& body : motion.bodies()) {
      const Vec3 hung = body.object == 2   ? bar.pose.position
                        : body.object == 3 ? cube.pose.position
                                           : ball.pose.position;
      if (body.object == next) continue;
      EXPECT_EQ(body.pose.position, hung) << body.object;
    }
    EXPECT_EQ(motion.bodyCount, 3U);
    hold(false, 10);
  }
  EXPECT_EQ(sample.object, 1U) << "the floor alone";
  EXPECT_LE(largest_N, 0.03 + 1e-9);
  EXPECT_NEAR(sample.force.written.z, kStiffness_N_per_m * 0.001, 1e-2) << "what begins in the floor is not pushed out";
  for (int i = 0; i <= 600; ++i) {
    const double lifted_m = 0.026 * std::sin(std::numbers::pi * i / 600);
    sample = servo.stepWith({{.position = {0, 0, 0.004 + lifted_m}, .state = DeviceState::kReady}});
  }
  EXPECT_NEAR(sample.force.written.z, kStiffness_N_per_m * 0.006, 0.1) << "the cube's side is at 10 mm";
  servo.adopt(sceneOf(2, {floorOf(1), bar, cube, ball, obstacle(6, makeSphere(0.01, 8).value(), {0.2, 0, 0})}));
  hold(true, 1);
  EXPECT_EQ(servo.state().tool.body, 3U) << "an edit leaves the cube in the hand, and this is another press";
}

TEST(HeldTool, NeitherAllocatesNorStepsTheForceAcrossEdits) {
  const ServoObject bar = toolOf(3, kBar), wider = toolOf(3, kBar, 2 * kSpacing_m);
  ServoObject softer = bar;
  softer.stiffness_N_per_m = 300;
  ServoObject turned = bar;
  turned.pose.rotation = glm::angleAxis(0.3, Vec3(0, 0, 1));
  ServoObject noTool = bar;
  noTool.tool = nullptr;
  noTool.pose.position = {0, 0, 0.3};
  ServoObject raised = floorOf(1);
  raised.pose.position.z += 0.001;
  const ServoObject plain = floorOf(1), other = obstacle(2, makeSphere(0.02, 8).value(), {0.1, 0, 0.02});
  VirtualServo servo(path({0, 0, 0.02}, {0.02, 0.01, 0.003}, 3), kConfig, sceneOf(1, {plain, bar}));
  Vec3 before = servo.run(300).force.written;
  double largest_N = 0;
  std::uint64_t revision = 1;
  const std::uint64_t allocations = AllocationTripwire::count();
  for (const auto& objects : std::vector<std::vector<ServoObject>>{{plain, softer},
                                                                   {plain, bar},
                                                                   {plain, other, bar},
                                                                   {plain, other, wider},
                                                                   {raised, other, wider},
                                                                   {raised, bar},
                                                                   {raised, turned},
                                                                   {plain, noTool},
                                                                   {plain, bar},
                                                                   {bar},
                                                                   {plain, bar}}) {
    servo.adopt(sceneOf(++revision, objects));
    for (int i = 0; i < 500; ++i) {
      std::optional<AllocationTripwire> armed;
      if (servo.adopted()) armed.emplace();
      const TelemetrySample sample = servo.step();
      armed.reset();
      ASSERT_EQ(sample.fault, Fault::kNone);
      largest_N = std::max(largest_N, glm::distance(sample.force.written, before));
      before = sample.force.written;
    }
  }
  EXPECT_LT(largest_N, 0.1);
  EXPECT_EQ(AllocationTripwire::count(), allocations);
}

/// Of a device that turns.
StepConfig turningConfig(bool stabilised = false) {
  StepConfig config = kConfig;
  config.rotation.maxTorque_Nm = 0.02;
  if (stabilised) {
    config.observer = ObserverSettings{.mass_kg = 0.3, .viscousFriction_Ns_per_m = 0.5, .delay_s = 1e-3};
    config.rotation.observer = config.observer;
  }
  return config;
}

DeviceReading turnedTo(Vec3 position, Vec3 angle) { return {position, DeviceState::kReady, {}, rotationBy(angle)}; }

TEST(HeldTool, TurnsWithTheDeviceAndGivesItTheTorqueOfWhatHoldsIt) {
  for (const bool stabilised : {false, true}) {
    VirtualServo servo(nullptr, turningConfig(stabilised), sceneOf(1, {floorOf(1), toolOf(2, kBar)}));
    for (int i = 0; i <= 400; ++i) (void)servo.stepWith(turnedTo({0, 0, 0.05}, {0, 0, 0.001 * i}));
    // Free: as the device, at 1 rad/s; with the stabiliser where it will be in a tick and a half.
    EXPECT_NEAR(rotationVector(proxyOf(servo, 1).rotation).z, 0.4 + (stabilised ? 1.5e-3 : 0),
                stabilised ? 1e-4 : 1e-9);
    EXPECT_NEAR(glm::length(writtenTorque_Nm(servo.state())), 0, 1e-9);
    // Pressed flat on the floor with 2 N, and turned about y by less than what tips it.
    for (int i = 0; i <= 1500; ++i) {
      const double down = std::min(1.0, i / 500.0), turned = std::min(1.0, std::max(0, i - 500) / 500.0);
      (void)servo.stepWith(turnedTo({0, 0, 0.05 - down * 0.0475}, {0, turned * 0.01, 0.4 * (1 - down)}));
    }
    EXPECT_NEAR(glm::length(rotationVector(proxyOf(servo, 1).rotation)), 0, 1e-4) << "it lies flat";
    const Vec3 torque_Nm = writtenTorque_Nm(servo.state());
    EXPECT_NEAR(glm::distance(torque_Nm, Vec3(0, -0.01, 0)), 0, 2e-4) << "1 Nm/rad turns the hand back";
    MotionState motion;
    EXPECT_TRUE(updateMotionState(servo.state(), 1, motion));
    EXPECT_EQ(motion.tool.written_Nm, torque_Nm);
    EXPECT_EQ(motion.tool.deviceRotation, rotationBy({0, 0.01, 0}));
  }
}

TEST(HeldTool, GivesNoMoreTorqueThanTheDeviceAndNoneToOneThatGivesNone) {
  for (const double limit_Nm : {0.02, 0.0}) {
    StepConfig config = turningConfig();
    config.rotation.maxTorque_Nm = limit_Nm;
    VirtualServo servo(nullptr, config, sceneOf(1, {floorOf(1), toolOf(2, kBar)}));
    for (int i = 0; i <= 1000; ++i) {
      const double part = std::min(1.0, i / 500.0);
      (void)servo.stepWith(turnedTo({0, 0, 0.02 - part * 0.035}, {0, part * 0.06, 0}));
      ASSERT_LE(glm::length(writtenTorque_Nm(servo.state())), limit_Nm * (1 + 1e-12));
    }
    EXPECT_NEAR(glm::length(writtenTorque_Nm(servo.state())), limit_Nm, 1e-12);
    EXPECT_GT(glm::length(servo.state().toolFelt.torque_Nm), 0.03);
  }
}

TEST(HeldTool, RampsTheTorqueAwayOnARotationThatIsNoneAndFadesItWhenTheToolGoes) {
  const ServoObject plain = floorOf(1), bar = toolOf(2, kBar);
  VirtualServo servo(nullptr, turningConfig(), sceneOf(1, {plain, bar}));
  constexpr double kMostInATick_Nm = RateLimitedStiffness::kRate_N_per_s * 0.05 * 1e-3;
  const auto press = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) (void)servo.stepWith(turnedTo({0, 0, 0.0025}, {0, 0.01, 0}));
  };
  for (int i = 0; i <= 300; ++i)
    (void)servo.stepWith(turnedTo({0, 0, 0.02 - i * 0.0175 / 300}, {0, i * 0.01 / 300, 0}));
  press(300);
  ASSERT_NEAR(glm::length(writtenTorque_Nm(servo.state())), 0.01, 2e-4);

  DeviceReading none = turnedTo({0, 0, 0.0025}, Vec3(0));
  none.rotation = Quat(std::nan(""), 0, 0, 0);
  const Vec3 before = writtenTorque_Nm(servo.state());
  EXPECT_EQ(servo.stepWith(none).fault, Fault::kNonFiniteInput);
  EXPECT_LT(glm::length(writtenTorque_Nm(servo.state())), glm::length(before));
  EXPECT_GT(glm::length(writtenTorque_Nm(servo.state())), 0.9 * glm::length(before));
  for (int i = 0; i < 30; ++i) (void)servo.stepWith(none);
  EXPECT_EQ(writtenTorque_Nm(servo.state()), Vec3(0));

  // Attached on the floor it is let out; pressed anew it feels the torque again.
  for (int i = 0; i <= 300; ++i)
    (void)servo.stepWith(turnedTo({0, 0, 0.02 - i * 0.0175 / 300}, {0, i * 0.01 / 300, 0}));
  press(300);
  ASSERT_NEAR(glm::length(writtenTorque_Nm(servo.state())), 0.01, 2e-4);
  ServoObject gone = bar;
  gone.tool = nullptr;
  gone.pose.position = {0, 0, 0.3};
  const auto scene = std::shared_ptr<const ServoScene>(sceneOf(2, {plain, gone}));
  servo.adopt(scene);
  Vec3 last = writtenTorque_Nm(servo.state());
  for (int i = 0; i < 300; ++i) {
    press(1);
    const Vec3 now = writtenTorque_Nm(servo.state());
    ASSERT_LE(glm::distance(now, last), kMostInATick_Nm + 1e-12) << i;
    last = now;
  }
  EXPECT_EQ(last, Vec3(0));
  EXPECT_FALSE(servo.state().features.torqueFades);
  EXPECT_FALSE(servo.state().features.extras);
}

TEST(HeldTool, TakesAnEditOfItsTorsionWithoutAStepOfTheTorque) {
  const ServoObject plain = floorOf(1), bar = toolOf(2, kBar);
  ServoObject twisted = bar;
  twisted.torsion_Nm_per_rad = 2;
  VirtualServo servo(nullptr, turningConfig(), sceneOf(1, {plain, bar}));
  for (int i = 0; i <= 300; ++i)
    (void)servo.stepWith(turnedTo({0, 0, 0.02 - i * 0.0175 / 300}, {0, i * 0.004 / 300, 0}));
  const auto hold = [&] { (void)servo.stepWith(turnedTo({0, 0, 0.0025}, {0, 0.004, 0})); };
  for (int i = 0; i < 200; ++i) hold();
  Vec3 last = writtenTorque_Nm(servo.state());
  ASSERT_NEAR(glm::length(last), 0.004, 1e-4);
  const auto scene = std::shared_ptr<const ServoScene>(sceneOf(2, {plain, twisted}));
  servo.adopt(scene);
  for (int i = 0; i < 200; ++i) {
    hold();
    const Vec3 now = writtenTorque_Nm(servo.state());
    ASSERT_LE(glm::distance(now, last), RateLimitedStiffness::kRate_N_per_s * 0.05 * 1e-3 + 1e-9) << i;
    last = now;
  }
  EXPECT_NEAR(glm::length(last), 0.008, 2e-4);
}

TEST(HeldTool, GoesOnFromACopyAndFromAnImageAlike) {
  const auto scene = [] { return sceneOf(1, {floorOf(1), brick(2, {0, 0.02, 0.02}, 0.1), toolOf(3, kBar)}); };
  const auto circle = [](std::uint64_t tick) {
    const double angle = 2e-3 * static_cast<double>(tick);
    return Vec3(0.03 * std::cos(angle), 0.03 * std::sin(angle),
                std::max(0.004, 0.02 - 4e-5 * static_cast<double>(tick)));
  };
  const auto shared = std::shared_ptr<const ServoScene>(scene());
  VirtualServo servo(circle, kConfig, shared);
  servo.run(700);
  const std::string image = stateImage(servo.state());
  auto fromImage = stateFrom(image, *shared, kConfig);
  ASSERT_TRUE(fromImage) << fromImage.error().reason;
  EXPECT_EQ(stateImage(**fromImage), image);
  const auto copied = std::make_unique<HapticState>(kConfig);
  copied->copyInUse(servo.state());
  int touching = 0;
  for (int i = 0; i < 3000; ++i) {
    const StepInput input{servo.tick(), 0, {circle(servo.tick()), DeviceState::kReady, {}}};
    const TelemetrySample sample = servo.step();
    touching += sample.object != 0 ? 1 : 0;
    expectSame(hapticStep(*shared, *copied, kConfig, input), sample, i);
    expectSame(hapticStep(*shared, **fromImage, kConfig, input), sample, i);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(touching, 500);
}

TEST(HeldTool, IsRefusedAnImageThatNamesWhatIsNotThere) {
  const auto scene = std::shared_ptr<const ServoScene>(sceneOf(1, {floorOf(1), toolOf(2, kBar)}));
  VirtualServo servo(path({0, 0, 0.02}, {0.01, 0, 0.002}, 0.2), kConfig, scene);
  servo.run(400);
  const std::string image = stateImage(servo.state());
  const auto shorter = std::shared_ptr<const ServoScene>(sceneOf(1, {floorOf(1), toolOf(2, kBar, 3 * kSpacing_m)}));
  EXPECT_FALSE(stateFrom(image, *shorter, kConfig));
  const auto without = std::shared_ptr<const ServoScene>(sceneOf(1, {floorOf(1), floorOf(2)}));
  EXPECT_FALSE(stateFrom(image, *without, kConfig));
}

TEST(HeldTool, FadesOnFaultsAndComesBackWhereTheDeviceIs) {
  VirtualServo servo(path({0, 0, 0.02}, {0, 0, 0.002}, 0.2), kConfig, sceneOf(1, {floorOf(1), toolOf(2, kBar)}));
  ASSERT_GT(servo.run(400).force.written.z, 2);
  TelemetrySample sample;
  for (int i = 0; i < 400; ++i) sample = servo.stepAt(Vec3(std::nan("")), DeviceState::kReady);
  EXPECT_EQ(glm::length(sample.force.written), 0);
  sample = servo.stepAt({0, 0, 0.1}, DeviceState::kReady);
  EXPECT_EQ(sample.fault, Fault::kNone);
  EXPECT_NEAR(proxyOf(servo, 1).position.z, 0.1, 1e-9);
}

constexpr double kMaxGrip_Nm = 0.1;

StepConfig grippingConfig() {
  StepConfig config = turningConfig();
  config.maxGrip_Nm = kMaxGrip_Nm;
  return config;
}

/// Two bars of 40 x 8 x 4 mm, one on the other.
ServoObject jawsOf(std::uint64_t id) {
  TriMesh mesh = makeBox({0.04, 0.008, 0.004}, 2).value();
  const TriMesh bar = mesh;
  const auto count = static_cast<std::uint32_t>(bar.vertices.size());
  for (Vec3f& v : mesh.vertices) v += Vec3f(0.022F, 0, 0.0021F);
  for (const Vec3f& v : bar.vertices) mesh.vertices.push_back(v + Vec3f(0.022F, 0, -0.0021F));
  for (const TriangleIndices& t : bar.triangles) mesh.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
  ServoObject object = objectOf(id, surfaceOf(mesh), {}, kStiffness_N_per_m);
  const JawHinge hinge{{0, 0, 0}, {0, -1, 0}, {1, 0, 0}};
  object.tool = std::make_shared<const Tool>(makeJaws(mesh.vertices, mesh.triangles, hinge, 0.002).value());
  object.torsion_Nm_per_rad = 1;
  object.grip_Nm_per_rad = 0.2;
  return object;
}

/// 8 mm high, between the jaws of a hand at the origin.
ServoObject pinched(std::uint64_t id) { return obstacle(id, makeBox({0.006, 0.02, 0.008}, 1).value(), {0.032, 0, 0}); }

DeviceReading openedTo(double gripper_rad, Vec3 position = Vec3(0)) {
  DeviceReading reading{{.position = position, .state = DeviceState::kReady}};
  reading.gripper_rad = gripper_rad;
  return reading;
}

/// Closes the jaws over what is there.
void closeTo(VirtualServo& servo, double opening_rad, double from_rad = 0.5) {
  for (int i = 0; i <= 500; ++i) (void)servo.stepWith(openedTo(from_rad + (opening_rad - from_rad) * i / 500.0));
  for (int i = 0; i < 100; ++i) (void)servo.stepWith(openedTo(opening_rad));
}

TEST(HeldTool, OpensItsJawsWithTheGripperAndGivesThatTheMomentOfWhatIsBetween) {
  const auto scene = std::shared_ptr<const ServoScene>(sceneOf(1, {pinched(1), jawsOf(2)}));
  VirtualServo servo(nullptr, grippingConfig(), scene);
  for (int i = 0; i < 10; ++i) (void)servo.stepWith(openedTo(0.5));
  MotionState motion;
  EXPECT_TRUE(updateMotionState(servo.state(), 1, motion));
  ASSERT_TRUE(motion.tool.grip);
  EXPECT_NEAR(motion.tool.grip->opening_rad, 0.5, 1e-9);
  EXPECT_NEAR(motion.tool.grip->moment_Nm, 0, 1e-9);
  closeTo(servo, 0.1);
  EXPECT_TRUE(updateMotionState(servo.state(), 1, motion));
  const double opening_rad = motion.tool.grip->opening_rad;
  EXPECT_GT(opening_rad, 0.2) << "the block is 8 mm high";
  EXPECT_NEAR(motion.tool.grip->moment_Nm, 0.2 * (opening_rad - 0.1), 1e-9);
  EXPECT_EQ(motion.tool.grip->written_Nm, motion.tool.grip->moment_Nm);
  EXPECT_EQ(writtenGrip_Nm(servo.state()), motion.tool.grip->written_Nm);
  EXPECT_GT(motion.tool.pointCount, 1U);
}

TEST(HeldTool, GivesTheGripperNoMoreThanItsLimitAndNoStepOnFaultsEditsAndWhereItLeaves) {
  const ServoObject block = pinched(1), jaws = jawsOf(2);
  ServoObject stiffer = jaws, rigid = toolOf(2, kBar);
  stiffer.grip_Nm_per_rad = 2;
  const auto scene = std::shared_ptr<const ServoScene>(sceneOf(1, {block, jaws}));
  VirtualServo servo(nullptr, grippingConfig(), scene);
  closeTo(servo, 0);
  constexpr double kMostInATick_Nm = RateLimitedStiffness::kRate_N_per_s * 0.05 * 1e-3 + 1e-12;
  double last = writtenGrip_Nm(servo.state()), largest = 0;
  ASSERT_GT(last, 0.03);
  const auto hold = [&](int ticks, const DeviceReading& reading) {
    const std::uint64_t allocations = AllocationTripwire::count();
    for (int i = 0; i < ticks; ++i) {
      const AllocationTripwire armed;
      (void)servo.stepWith(reading);
      const double now = writtenGrip_Nm(servo.state());
      largest = std::max(largest, std::abs(now - last));
      ASSERT_LE(std::abs(now), kMaxGrip_Nm * (1 + 1e-12)) << i;
      last = now;
    }
    EXPECT_EQ(AllocationTripwire::count(), allocations);
  };
  const auto harder = std::shared_ptr<const ServoScene>(sceneOf(2, {block, stiffer}));
  servo.adopt(harder);
  hold(300, openedTo(0));
  EXPECT_NEAR(last, kMaxGrip_Nm, 1e-12);
  servo.adopt(std::shared_ptr<const ServoScene>(sceneOf(3, {block, jaws})));
  hold(300, openedTo(0));
  EXPECT_LT(last, 0.06);
  EXPECT_LE(largest, kMostInATick_Nm) << "edits";

  largest = 0;
  hold(1, openedTo(std::nan("")));
  EXPECT_GT(last, 0.03) << "it fades";
  hold(60, openedTo(std::nan("")));
  EXPECT_EQ(last, 0);
  EXPECT_LT(largest, 0.01);
  hold(5, openedTo(0.6));
  closeTo(servo, 0);
  last = writtenGrip_Nm(servo.state());
  ASSERT_GT(last, 0.03);
  for (int i = 0; i < 60; ++i) {
    DeviceReading lost = openedTo(0);
    lost.state = DeviceState::kAbsent;
    hold(1, lost);
  }
  EXPECT_EQ(last, 0) << "the device is lost";
  hold(5, openedTo(0.6));
  closeTo(servo, 0);
  last = writtenGrip_Nm(servo.state());
  ASSERT_GT(last, 0.03);
  largest = 0;
  servo.adopt(std::shared_ptr<const ServoScene>(sceneOf(4, {block, rigid})));
  hold(300, openedTo(0));
  EXPECT_EQ(last, 0) << "a tool without jaws";
  EXPECT_FALSE(servo.state().tool.grips);
  EXPECT_LE(largest, kMostInATick_Nm);
  servo.adopt(std::shared_ptr<const ServoScene>(sceneOf(5, {block, jaws})));
  hold(300, openedTo(0.3));
  servo.adopt(std::shared_ptr<const ServoScene>(sceneOf(6, {block})));
  hold(300, openedTo(0.3));
  EXPECT_EQ(last, 0) << "no tool";
  EXPECT_LE(largest, kMostInATick_Nm);
  EXPECT_FALSE(servo.state().features.extras);
}

TEST(HeldTool, WithJawsIsGivenNoMoreWhereTheGripperJumps) {
  const auto scene = std::shared_ptr<const ServoScene>(sceneOf(1, {pinched(1), jawsOf(2)}));
  VirtualServo servo(nullptr, grippingConfig(), scene);
  closeTo(servo, 0.1);
  for (const double gripper_rad : {0.5, -2.0, 1e300, 0.0, 3.0, -1e-300, 0.05}) {
    for (int i = 0; i < 50; ++i) {
      const TelemetrySample sample = servo.stepWith(openedTo(gripper_rad));
      ASSERT_EQ(sample.fault, Fault::kNone);
      ASSERT_LE(std::abs(writtenGrip_Nm(servo.state())), kMaxGrip_Nm * (1 + 1e-12));
      ASSERT_TRUE(isFinite(sample.force.written));
      ASSERT_GE(servo.state().tool.memory.proxy.opening_rad, 0);
    }
  }
}

TEST(HeldTool, WithJawsPinchesWhatMovesFromBothSides) {
  ServoObject ball = brick(1, {0.03, 0, 0.001}, 0.05);
  const TriMesh mesh = makeSphere(0.004, 8).value();
  ball.surface = surfaceOf(mesh);
  ball.sharp = std::make_shared<const std::vector<Vec3>>();
  const auto scene = std::shared_ptr<const ServoScene>(sceneOf(1, {ball, jawsOf(2)}));
  VirtualServo servo(nullptr, grippingConfig(), scene);
  closeTo(servo, 0.05);
  MotionState motion;
  (void)updateMotionState(servo.state(), 1, motion);
  EXPECT_LT(std::abs(servo.state().bodies[0].current.position.z), 0.001) << "it comes to the middle";
  EXPECT_GT(servo.state().bodies[0].current.position.x, 0.03) << "and is driven out";
  EXPECT_TRUE(isFinite(servo.state().bodies[0].current.position));
}

TEST(HeldTool, WithJawsGoesOnFromACopyAndFromAnImageAlike) {
  const auto scene = std::shared_ptr<const ServoScene>(sceneOf(1, {pinched(1), jawsOf(2)}));
  const StepConfig config = grippingConfig();
  VirtualServo servo(nullptr, config, scene);
  closeTo(servo, 0.1);
  const std::string image = stateImage(servo.state());
  auto fromImage = stateFrom(image, *scene, config);
  ASSERT_TRUE(fromImage) << fromImage.error().reason;
  EXPECT_EQ(stateImage(**fromImage), image);
  const auto copied = std::make_unique<HapticState>(config);
  copied->copyInUse(servo.state());
  for (int i = 0; i < 500; ++i) {
    const DeviceReading reading = openedTo(0.2 + 0.2 * std::sin(0.02 * i), {0.002 * std::sin(0.03 * i), 0, 0});
    const StepInput input{servo.tick(), 0, reading};
    const TelemetrySample sample = servo.stepWith(reading);
    expectSame(hapticStep(*scene, *copied, config, input), sample, i);
    expectSame(hapticStep(*scene, **fromImage, config, input), sample, i);
    ASSERT_EQ(writtenGrip_Nm(*copied), writtenGrip_Nm(servo.state())) << i;
    ASSERT_EQ(writtenGrip_Nm(**fromImage), writtenGrip_Nm(servo.state())) << i;
    if (HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace haptics::fixture::held_tool_tests

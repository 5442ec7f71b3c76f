#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "common/mesh/generators.h"
#include "haptic_server/collision/collision_points.h"
#include "haptic_server/geometry/spaced_points.h"
#include "haptic_server/motion/solid.h"
#include "haptic_server/recording/state_image.h"
#include "haptic_server/servo/allocation_tripwire.h"
#include "haptic_server/step/moving_bodies.h"
#include "tests/haptic_server/step/virtual_servo.h"

namespace haptics::testing {
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
  EXPECT_TRUE(describeMotion(servo.state(), 1, motion));
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

}  // namespace
}  // namespace haptics::testing

#include <gtest/gtest.h>

#include <numeric>

#include "common/maths/rotation.h"
#include "haptic_server/engine/motion/solid.h"
#include "haptic_server/engine/motion/support_points.h"
#include "haptic_server/engine/step/tool_step.h"
#include "tests/haptic_server/engine/step/surface_world.h"

namespace haptics::fixture::added_wrench_tests {
namespace {

const StepConfig kConfig{.maxForce_N = 20, .rotation = {.maxTorque_Nm = 0.1}};
const Wrench kAdded{{0.5, -0.3, -0.7}, {0.02, 0, 0.01}};

/// In and out of the slab, along it.
Vec3 stroke(std::uint64_t tick) {
  const double t = 1e-3 * static_cast<double>(tick);
  return {0.02 * std::sin(2 * t), 0.01, 0.003 * std::cos(5 * t)};
}

DeviceReading readingAt(Vec3 position, const Wrench& added = {}) {
  DeviceReading reading{position, DeviceState::kReady, {}};
  reading.added = AddedWrench(added);
  return reading;
}

double sum(const EnergyByFeature& given_J) { return std::accumulate(given_J.begin(), given_J.end(), 0.0); }

class AddedWrenchTest : public testing::Test {
 protected:
  const TelemetrySample& step(const Wrench& added) {
    return sample_ = servo_.stepWith(readingAt(stroke(servo_.tick()), added));
  }

  VirtualServo servo_{{}, kConfig, sceneOf(1, {with(slab(), friction(0.6, 0.4))})};
  TelemetrySample sample_;
};

TEST_F(AddedWrenchTest, ActsBesideTheContactInWhichItChangesNothing) {
  VirtualServo without({}, kConfig, sceneOf(1, {with(slab(), friction(0.6, 0.4))}));
  int touched = 0;
  for (int i = 0; i < 200; ++i) {  // until the scene is felt in full
    (void)without.stepWith(readingAt(stroke(without.tick())));
    step({});
  }
  for (int i = 0; i < 2000; ++i) {
    const TelemetrySample alone = without.stepWith(readingAt(stroke(without.tick())));
    step(kAdded);
    EXPECT_EQ(sample_.force.contact, alone.force.contact);
    EXPECT_EQ(sample_.added_N, kAdded.force_N);
    EXPECT_EQ(sample_.force.written, alone.force.contact + kAdded.force_N);
    touched += sample_.object != 0;
  }
  EXPECT_GT(touched, 500);
  EXPECT_LT(touched, 1500);
}

TEST_F(AddedWrenchTest, ItsWorkIsTheClientsAndNoObjects) {
  double work_J = 0, added_J = 0;
  Vec3 written(0), held(0);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 way = stroke(servo_.tick()) - stroke(servo_.tick() - (i > 0 ? 1 : 0));
    work_J += glm::dot(written, way);
    added_J += glm::dot(held, way);
    const Wrench added{kAdded.force_N * std::sin(1e-2 * i), {}};
    written = step(added).force.written;
    held = added.force_N;
  }
  const EnergyByFeature all = servo_.state().energy.all_J();
  EXPECT_NEAR(sum(all), work_J, 1e-12);
  EXPECT_GT(std::abs(added_J), 1e-3);
  EXPECT_NEAR(all[static_cast<std::size_t>(EnergyFeature::kWrench)], added_J, 1e-12);
  EnergyState told;
  servo_.state().energy.copyTo(told);
  ASSERT_EQ(told.objectCount, 1U);
  EXPECT_EQ(told.object[0].of(EnergyFeature::kWrench), 0);
}

TEST_F(AddedWrenchTest, StaysWithTheContactWithinTheDevicesLimits) {
  for (int i = 0; i < 1000; ++i) EXPECT_LE(glm::length(step({{50, 0, 0}, {}}).force.written), 20 + 1e-12);
  EXPECT_EQ(glm::length(writtenTorque_Nm(servo_.state(), kConfig, AddedWrench({{}, {3, 0, 4}}))), 0.1);
  EXPECT_EQ(writtenTorque_Nm(servo_.state(), kConfig, AddedWrench(kAdded)), kAdded.torque_Nm);
  StepConfig without = kConfig;
  without.rotation.maxTorque_Nm = 0;
  EXPECT_EQ(writtenTorque_Nm(servo_.state(), without, AddedWrench(kAdded)), Vec3(0));
}

TEST_F(AddedWrenchTest, GoesWithTheForceOfADeviceThatIsLost) {
  for (int i = 0; i < 100; ++i) step(kAdded);
  DeviceReading lost = readingAt(stroke(100), kAdded);
  lost.state = DeviceState::kAbsent;
  Vec3 before = sample_.force.written;
  for (int i = 0; i < 20; ++i) {
    const Vec3 now = servo_.stepWith(lost).force.written;
    EXPECT_LT(glm::distance(now, before), 0.3);
    before = now;
  }
  EXPECT_LT(glm::length(before), 1e-12);
  EXPECT_LT(glm::length(writtenTorque_Nm(servo_.state(), kConfig, lost.added)), 1e-12);
}

TEST_F(AddedWrenchTest, IsNotFeltWhileTheHandMovesItsWorkspace) {
  for (int i = 0; i < 100; ++i) step(kAdded);
  DeviceReading reading = readingAt(stroke(100), kAdded);
  reading.status.set(HandAction::kClutch, true);
  Vec3 before = sample_.force.written;
  for (int i = 0; i < 200; ++i) {
    const Vec3 now = servo_.stepWith(reading).force.written;
    EXPECT_LT(glm::distance(now, before), 0.03 + 1e-9);
    before = now;
  }
  EXPECT_EQ(before, Vec3(0));
  EXPECT_EQ(writtenTorque_Nm(servo_.state(), kConfig, reading.added), Vec3(0));
}

TEST_F(AddedWrenchTest, ThatIsNoNumberIsAFaultAndNoForce) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  step({{nan, 0, 0}, {nan, 0, 0}});
  EXPECT_EQ(sample_.fault, Fault::kNonFiniteForce);
  EXPECT_TRUE(isFinite(sample_.force.written));
  EXPECT_TRUE(isFinite(writtenTorque_Nm(servo_.state(), kConfig, AddedWrench({{nan, 0, 0}, {nan, 0, 0}}))));
}

TEST(AddedWrench, PushesNoBody) {
  const TriMesh mesh = makeBox(Vec3(0.06), 2).value();
  RigidBody body;
  const Solid solid = solidOf(mesh.vertices, mesh.triangles);
  ASSERT_EQ(spreadMass(0.2, solid.centre, 0.2 / solid.volume_m3 * solid.inertia, body.mass), MassDefect::kNone);
  body.setSupport(supportPoints(mesh.vertices));
  body.gravity_m_per_s2 = Vec3(0);
  ServoObject box = objectOf(1, surfaceOf(mesh), Vec3(0, 0, -0.03));
  box.motion = std::make_shared<RigidBody>(body);
  VirtualServo with({}, kConfig, sceneOf(1, {box})), without({}, kConfig, sceneOf(1, {box}));
  for (int i = 0; i < 1000; ++i) {
    const Vec3 down(0.01, 0, 0.002 - 1e-5 * i);
    (void)with.stepWith(readingAt(down, kAdded));
    (void)without.stepWith(readingAt(down));
  }
  EXPECT_LT(with.state().moving[0].state.momentum_Ns.z, -1e-3);
  EXPECT_EQ(with.state().moving[0].state.momentum_Ns, without.state().moving[0].state.momentum_Ns);
}

}  // namespace
}  // namespace haptics::fixture::added_wrench_tests

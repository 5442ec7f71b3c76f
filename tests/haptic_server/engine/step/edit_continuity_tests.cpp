// Edits under the stylus: the same HIP trajectory with the edit and without it, from one state.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/mesh/generators.h"
#include "tests/haptic_server/engine/step/virtual_servo.h"

namespace haptics::edit_continuity_tests {
namespace {

using namespace fixture;

constexpr StepConfig kConfig{.period_s = 1e-3, .maxForce_N = 100};
constexpr double kRadius_m = 0.05;
constexpr std::uint64_t kEditTick = 400;
constexpr std::uint64_t kWatched = 400;

/// Down on the top of a sphere about the origin, then along a great circle at 50 mm/s, 2 to 3 mm deep.
Vec3 stroke(std::uint64_t tick) {
  const double t = 1e-3 * static_cast<double>(tick);
  const double depth = std::min(0.05 * t - 0.005, 0.0025) + (t > 0.2 ? 0.0005 * std::sin(20 * t) : 0);
  const double angle = std::max(0.0, t - 0.2) * 0.05 / kRadius_m;
  return (kRadius_m - depth) * Vec3(std::sin(angle), 0.03, std::cos(angle));
}

struct Steps {
  double adoption_N = 0;  ///< Step of the contact force, before blend and limit, into the tick of the adoption.
  double contact_N = 0;   ///< The same, largest of all ticks watched.
  double written_N = 0;
  std::uint64_t waited = 0;     ///< Ticks until the edit was adopted.
  std::uint64_t freeTicks = 0;  ///< Without contact.
  TelemetrySample last;
};

Steps watch(VirtualServo servo, const TelemetrySample& before) {
  Steps steps;
  steps.last = before;
  for (std::uint64_t i = 0; i < kWatched; ++i) {
    const TelemetrySample now = servo.step();
    const double step_N = glm::length(now.force.contact - steps.last.force.contact);
    if (i == 0) steps.adoption_N = step_N;
    steps.contact_N = std::max(steps.contact_N, step_N);
    steps.written_N = std::max(steps.written_N, glm::length(now.force.written - steps.last.force.written));
    steps.waited += servo.adopted() ? 0 : 1;
    steps.freeTicks += now.object == 0 ? 1 : 0;
    steps.last = now;
  }
  return steps;
}

class EditUnderTheStylus : public ::testing::Test {
 protected:
  void SetUp() override {
    servo_.adopt(sceneOf(1, {sphere_}));
    before_ = servo_.run(kEditTick);
    ASSERT_EQ(before_.object, 1U) << "the stylus must be in contact";
    without_ = watch(servo_, before_);
  }
  Steps withEdit(std::vector<ServoObject> objects) {
    VirtualServo edited = servo_;
    edited.adopt(sceneOf(2, std::move(objects)));
    return watch(edited, before_);
  }
  /// What the trajectory does by itself on one of the two scenes.
  [[nodiscard]] double ownStep_N(std::vector<ServoObject> objects) const {
    VirtualServo always(stroke, kConfig, sceneOf(1, std::move(objects)));
    const TelemetrySample before = always.run(kEditTick);
    return std::max(without_.contact_N, watch(always, before).contact_N);
  }
  /// In the tick of the adoption nothing but what the trajectory itself does, and later no more than it does on one of
  /// the two scenes: stiffer or coarser surfaces have larger steps of their own.
  void expectNoStep(const Steps& with, std::vector<ServoObject> objects) const {
    const double own_N = ownStep_N(std::move(objects));
    EXPECT_LE(with.adoption_N, 1.1 * without_.contact_N + 0.05);
    EXPECT_LE(with.contact_N, 1.1 * own_N + 0.05);
  }

  ServoObject sphere_ = objectOf(1, surfaceOf(makeSphere(kRadius_m, 48).value()), Vec3(0));
  VirtualServo servo_{stroke, kConfig};
  TelemetrySample before_;
  Steps without_;
};

TEST_F(EditUnderTheStylus, AStifferMaterialComesWithoutAStep) {
  ServoObject stiffer = sphere_;
  stiffer.stiffness_N_per_m = 3000;
  const Steps with = withEdit({stiffer});
  expectNoStep(with, {stiffer});
  EXPECT_NEAR(glm::length(with.last.force.spring), 3000 * with.last.penetration_m, 1e-6) << "and does come";
}

TEST_F(EditUnderTheStylus, ASofterMaterialComesWithoutAStep) {
  ServoObject softer = sphere_;
  softer.stiffness_N_per_m = 100;
  softer.damping_Ns_per_m = 5;
  expectNoStep(withEdit({softer}), {softer});
}

TEST_F(EditUnderTheStylus, ARemeshOfTheSameShapeKeepsTheContact) {
  for (const std::uint32_t segments : {24U, 47U, 96U}) {
    ServoObject remeshed = sphere_;
    remeshed.surface = surfaceOf(makeSphere(kRadius_m, segments).value());
    const Steps with = withEdit({remeshed});
    expectNoStep(with, {remeshed});
    EXPECT_EQ(with.last.object, 1U);
  }
}

TEST_F(EditUnderTheStylus, AnObjectAddedElsewhereIsNotFeltAtAll) {
  const Steps with = withEdit({sphere_, objectOf(2, surfaceOf(makeBox(Vec3(0.05), 4).value()), Vec3(0.3, 0, 0))});
  EXPECT_EQ(with.contact_N, without_.contact_N);
  EXPECT_EQ(with.written_N, without_.written_N);
}

TEST_F(EditUnderTheStylus, ARemovedObjectFadesAndIsGone) {
  ServoObject pendingRemoval = sphere_;
  pendingRemoval.pendingRemoval = true;
  const Steps with = withEdit({pendingRemoval});
  expectNoStep(with, {sphere_});
  EXPECT_EQ(with.last.force.written, Vec3(0));
  EXPECT_EQ(withEdit({}).last.object, 0U);
}

TEST_F(EditUnderTheStylus, AnObjectMovedAndRemovedInOneAdoptionFadesAndIsGone) {
  ServoObject pendingRemoval = sphere_;
  pendingRemoval.pose.position = Vec3(0, 0, 0.002);
  pendingRemoval.pendingRemoval = true;
  const Steps with = withEdit({pendingRemoval});
  expectNoStep(with, {sphere_});
  EXPECT_EQ(with.last.force.written, Vec3(0));
}

TEST_F(EditUnderTheStylus, AnObjectAddedAroundAFreeStylusPushesItOutGently) {
  VirtualServo servo([](std::uint64_t) { return Vec3(0.002, 0.003, 0.045); }, kConfig, sceneOf(1, {}));
  const TelemetrySample free = servo.run(10);
  servo.adopt(sceneOf(2, {sphere_}));
  const Steps with = watch(servo, free);
  EXPECT_LE(with.contact_N, 0.05);
  EXPECT_EQ(with.last.object, 1U);
  EXPECT_NEAR(glm::length(with.last.force.written), 800 * with.last.penetration_m, 1e-6);
  EXPECT_NEAR(with.last.penetration_m, kRadius_m - glm::length(with.last.hip), 2e-4);
}

TEST_F(EditUnderTheStylus, AShortWayOfTheObjectIsFeltAsAMotionThatKeepsTheContact) {
  const Quat turned = glm::angleAxis(0.03, glm::normalize(Vec3(1, 2, 3)));
  for (const Pose& pose :
       {Pose{{1, 0, 0, 0}, {0, 0, 0.002}}, Pose{{1, 0, 0, 0}, {0, 0.004, -0.001}}, Pose{turned, {}}}) {
    ServoObject moved = sphere_;
    moved.pose = pose;
    const Steps with = withEdit({moved});
    expectNoStep(with, {moved});
    EXPECT_EQ(with.waited, 0U) << "felt from the very tick";
    EXPECT_EQ(with.freeTicks, 0U);
    EXPECT_NEAR(with.last.penetration_m, kRadius_m - glm::distance(with.last.hip, pose.position), 5e-5) << "and there";
  }
}

TEST_F(EditUnderTheStylus, AnObjectMovedFarAwayIsLetGo) {
  ServoObject moved = sphere_;
  moved.pose.position = Vec3(0, 0, -0.2);
  const Steps with = withEdit({moved});
  expectNoStep(with, {sphere_});
  EXPECT_EQ(with.last.object, 0U);
  EXPECT_EQ(with.last.force.written, Vec3(0));
}

TEST_F(EditUnderTheStylus, WhatNeedsAnotherContactIsLetGoFirstAndThenPushesTheStylusOutGently) {
  ServoObject farther = sphere_;
  farther.pose.position = Vec3(0.02, 0, 0);
  ServoObject larger = sphere_;
  larger.surface = surfaceOf(makeSphere(kRadius_m + 0.004, 48).value());
  const ServoObject over = objectOf(2, surfaceOf(makeBox(Vec3(0.06), 4).value()), Vec3(0, 0, kRadius_m));
  for (const std::vector<ServoObject>& objects :
       {std::vector{farther}, std::vector{larger}, std::vector{sphere_, over}}) {
    const Steps with = withEdit(objects);
    expectNoStep(with, objects);
    EXPECT_GT(with.waited, 10U);
    EXPECT_LT(with.waited, 150U);
    EXPECT_NE(with.last.object, 0U);
    EXPECT_NEAR(glm::length(with.last.force.written), glm::length(with.last.force.contact), 0.01);
  }
}

TEST_F(EditUnderTheStylus, ASmallStepOnTheSameObjectIsLetInWithoutLettingGo) {
  ServoObject larger = sphere_;
  larger.surface = surfaceOf(makeSphere(kRadius_m + 0.0005, 48).value());
  const Steps with = withEdit({larger});
  EXPECT_EQ(with.waited, 0U);
  EXPECT_EQ(with.freeTicks, 0U);
  EXPECT_GT(with.adoption_N, 0.3) << "the edit must change the contact force at once";
  EXPECT_LE(with.written_N, 1.1 * ownStep_N({larger}) + EditSlew::kRate_N_per_s * kConfig.period_s);
  EXPECT_NEAR(glm::length(with.last.force.written), glm::length(with.last.force.contact), 0.01);
}

TEST_F(EditUnderTheStylus, ABallThatGrowsInManySmallEditsPushesTheRestingHand) {
  constexpr double kSlow_m = 4e-5;  // an edit
  const Vec3 hip(0, 0, kRadius_m - 0.002);
  VirtualServo servo(
      [&](std::uint64_t tick) {
        return tick < 200 ? Vec3(0, 0, kRadius_m + 0.01) - 6e-5 * static_cast<double>(tick) * Vec3(0, 0, 1) : hip;
      },
      kConfig, sceneOf(1, {sphere_}));
  servo.run(500);
  double grown_m = 0;
  for (std::uint64_t revision = 2; revision < 52; ++revision) {
    grown_m += kSlow_m;
    ServoObject ball = sphere_;
    ball.surface = surfaceOf(makeSphere(kRadius_m + grown_m, 48).value());
    servo.adopt(sceneOf(revision, {ball}));
    for (int i = 0; i < 20; ++i) {
      const TelemetrySample sample = servo.step();
      const double depth_m = kRadius_m + grown_m - hip.z;
      ASSERT_NEAR(sample.force.written.z, 800 * depth_m, 800 * kSlow_m + 0.02) << "edit " << revision << ", tick " << i;
    }
  }
}

TEST_F(EditUnderTheStylus, AnObjectMovedOverAFreeStylusPushesItOutGently) {
  VirtualServo servo([](std::uint64_t) { return Vec3(0.002, 0.003, 0.045); }, kConfig);
  ServoObject away = sphere_;
  away.pose.position = Vec3(0, 0, -0.2);
  servo.adopt(sceneOf(1, {away}));
  const TelemetrySample free = servo.run(10);
  servo.adopt(sceneOf(2, {sphere_}));
  const Steps with = watch(servo, free);
  EXPECT_EQ(with.waited, 0U);
  EXPECT_LE(with.contact_N, 0.05);
  EXPECT_NEAR(glm::length(with.last.force.written), 800 * with.last.penetration_m, 1e-6);
}

/// While the device is gone nobody feels it, and it need not fade.
TEST_F(EditUnderTheStylus, AnEditIsAdoptedAtOnceWhileTheDeviceIsGone) {
  const Vec3 hand = stroke(servo_.tick());
  for (int i = 0; i < 500; ++i) static_cast<void>(servo_.stepAt(hand, DeviceState::kAbsent));
  ServoObject moved = sphere_;
  moved.pose.position = {0, 0, 0.1};
  moved.poseRevision = 2;
  servo_.adopt(sceneOf(2, {moved}));
  EXPECT_TRUE(servo_.adopted());
  EXPECT_EQ(servo_.state().bodies[0].current, moved.pose);
  TelemetrySample last;
  for (int i = 0; i < 600; ++i) {
    const TelemetrySample now = servo_.stepAt(hand, DeviceState::kReady);
    if (i > 0) ASSERT_LT(glm::distance(now.force.written, last.force.written), 0.031) << i;
    last = now;
  }
}

/// One that was on its way is where the scene has it.
TEST_F(EditUnderTheStylus, AnObjectThatIsBeingMovedIsThereWhenTheDeviceIsGone) {
  ServoObject moved = sphere_;
  moved.pose.position = {0, 0, 0.001};
  moved.poseRevision = 2;
  servo_.adopt(sceneOf(2, {moved}));
  static_cast<void>(servo_.step());
  ASSERT_TRUE(servo_.state().objects[0].beingMoved);
  for (int i = 0; i < 2; ++i) static_cast<void>(servo_.stepAt(stroke(servo_.tick()), DeviceState::kAbsent));
  EXPECT_FALSE(servo_.state().objects[0].beingMoved);
  EXPECT_EQ(servo_.state().bodies[0].current, moved.pose);
}

TEST_F(EditUnderTheStylus, ATooStrongContactIsNotWaitedForLong) {
  VirtualServo servo(
      [](std::uint64_t tick) { return Vec3(0, 0, kRadius_m + 0.001 - 1e-4 * static_cast<double>(tick)); },
      kConfig);  // pushes on
  servo.adopt(sceneOf(1, {sphere_}));
  const TelemetrySample pushed = servo.run(200);
  ServoObject moved = sphere_;
  moved.pose.position = Vec3(0, 0, -0.2);
  servo.adopt(sceneOf(2, {moved}));
  EXPECT_NEAR(static_cast<double>(watch(servo, pushed).waited), 250, 1);
}

}  // namespace
}  // namespace haptics::edit_continuity_tests

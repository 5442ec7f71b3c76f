// Edits under the stylus: the same HIP trajectory with the edit and without it, from one state.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/mesh/generators.h"
#include "virtual_servo.h"

namespace haptics {
namespace {

using testing::objectOf;
using testing::sceneOf;
using testing::surfaceOf;
using testing::VirtualServo;

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
  /// In the tick of the adoption nothing but what the trajectory itself does, and later no more than it does on one of
  /// the two scenes: stiffer or coarser surfaces have larger steps of their own.
  void expectNoStep(const Steps& with, std::vector<ServoObject> objects) const {
    VirtualServo always(stroke, kConfig);
    always.adopt(sceneOf(1, std::move(objects)));
    const TelemetrySample before = always.run(kEditTick);
    const double own_N = std::max(without_.contact_N, watch(always, before).contact_N);
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
  ServoObject leaving = sphere_;
  leaving.leaving = true;
  const Steps with = withEdit({leaving});
  expectNoStep(with, {sphere_});
  EXPECT_EQ(with.last.force.written, Vec3(0));
  EXPECT_EQ(withEdit({}).last.object, 0U);
}

TEST_F(EditUnderTheStylus, AnObjectAddedAroundAFreeStylusPushesItOutGently) {
  VirtualServo servo([](std::uint64_t) { return Vec3(0.002, 0.003, 0.045); }, kConfig);
  servo.adopt(sceneOf(1, {}));
  const TelemetrySample free = servo.run(10);
  servo.adopt(sceneOf(2, {sphere_}));
  const Steps with = watch(servo, free);
  EXPECT_LE(with.contact_N, 0.05);
  EXPECT_EQ(with.last.object, 1U);
  EXPECT_NEAR(glm::length(with.last.force.written), 800 * with.last.penetration_m, 1e-6);
  EXPECT_NEAR(with.last.penetration_m, kRadius_m - glm::length(with.last.hip), 2e-4);
}

TEST_F(EditUnderTheStylus, AnObjectMovedAwayIsBlendedOutIn50Milliseconds) {
  ServoObject moved = sphere_;
  moved.pose.position = Vec3(0, 0, -0.2);
  const Steps with = withEdit({moved});
  EXPECT_EQ(with.last.object, 0U);
  EXPECT_LE(with.written_N, glm::length(before_.force.written) / 50 + without_.written_N + 0.05);
}

TEST_F(EditUnderTheStylus, AnObjectMovedFartherOverTheStylusIsBlendedIn) {
  ServoObject moved = sphere_;
  moved.pose.position = Vec3(0, 0, 0.004);
  const Steps with = withEdit({moved});
  EXPECT_EQ(with.last.object, 1U);
  EXPECT_LE(with.written_N, 800 * 0.005 / 50 + without_.written_N + 0.05);
}

}  // namespace
}  // namespace haptics

// Edits of surface properties under the stylus.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/haptic_server/engine/step/surface_world.h"

namespace haptics::surface_edit_tests {
namespace {

using namespace fixture;

/// What an edit may change the written force by in a tick.
constexpr double kLetIn_N = EditSlew::kRate_N_per_s * 1e-3 + 1e-9;

class SurfaceEdit : public ::testing::Test {
 protected:
  struct Steps {
    double contact_N = 0;  ///< Before blend and limit.
    double written_N = 0;
  };
  /// Largest steps of the force around an edit under the stylus, less the largest that either scene has by itself.
  static Steps steps(const ServoObject& before, const ServoObject& after) {
    const Steps edited = largest(before, after), first = largest(before, before), second = largest(after, after);
    return {edited.contact_N - std::max(first.contact_N, second.contact_N),
            edited.written_N - std::max(first.written_N, second.written_N)};
  }

 private:
  static Steps largest(const ServoObject& before, const ServoObject& after) {
    VirtualServo servo(strokeAlongX(0.002, 0.02), kConfig, sceneOf(1, {before}));
    servo.run(600);
    Steps steps;
    ForceComponents last = servo.step().force;
    servo.adopt(sceneOf(2, {after}));
    for (int i = 0; i < 300; ++i) {
      const ForceComponents now = servo.step().force;
      steps.contact_N = std::max(steps.contact_N, glm::length(now.contact - last.contact));
      steps.written_N = std::max(steps.written_N, glm::length(now.written - last.written));
      last = now;
    }
    return steps;
  }
};

TEST_F(SurfaceEdit, ThatAddsATextureMakesNoStep) {
  const Steps added = steps(slab(), withGrating(slab(), 0.003, 0.0002));
  EXPECT_LE(added.contact_N, 0.02);
  EXPECT_LE(added.written_N, 0.02);
}

TEST_F(SurfaceEdit, OfATexturesAmplitudeMakesNoStep) {
  EXPECT_LE(steps(withGrating(slab(), 0.003, 0.0002), withGrating(slab(), 0.003, 0.0004)).contact_N, 0.03);
  for (const double amplitude : {0.0004, 0.0001}) {
    const Steps changed = steps(withGrating(slab(), 0.003, 0.0002), withGrating(slab(), 0.003, amplitude));
    EXPECT_LE(changed.written_N, 0.03) << amplitude;
  }
}

TEST_F(SurfaceEdit, OfATexturesFieldOrItsRemovalMakesNoStepOfTheForceThatIsWritten) {
  EXPECT_LE(steps(withGrating(slab(), 0.003, 0.0002), slab()).written_N, kLetIn_N);
  EXPECT_LE(steps(withGrating(slab(), 0.003, 0.0002), withGrating(slab(), 0.004, 0.0005)).written_N, kLetIn_N);
}

TEST_F(SurfaceEdit, OfFrictionMakesNoStep) {
  EXPECT_LE(steps(slab(), with(slab(), friction(0.8, 0.8))).contact_N, 0.03);
  EXPECT_LE(steps(with(slab(), friction(0.8, 0.8)), slab()).written_N, kLetIn_N);
  for (const double mu : {0.2, 1.2}) {
    const Steps changed = steps(with(slab(), friction(0.6, 0.6)), with(slab(), friction(mu, mu)));
    EXPECT_LE(changed.contact_N, 0.03) << mu;
    EXPECT_LE(changed.written_N, 0.03) << mu;
  }
}

TEST_F(SurfaceEdit, ToATallerTextureIsFeltByAStylusThatHoversOverIt) {
  VirtualServo servo([](std::uint64_t) { return Vec3(0, 0.0123, 0.0005); }, kConfig,
                     sceneOf(1, {withGrating(slab(), 0.004, 0.0001)}));
  EXPECT_EQ(servo.run(100).object, 0U);
  servo.adopt(sceneOf(2, {withGrating(slab(), 0.004, 0.0004)}));
  const TelemetrySample after = servo.run(100);
  EXPECT_EQ(after.object, 1U);
  EXPECT_NEAR(after.force.contact.z, kStiffness * 0.0003, 1e-6);
}

TEST_F(SurfaceEdit, OfThePoseMakesNoStepWhereOnlyABumpReachesTheStylus) {
  const ServoObject object = withGrating(slab(), 0.004, 0.0004);
  VirtualServo servo([](std::uint64_t) { return Vec3(0, 0.0123, 0.0005); }, kConfig, sceneOf(1, {object}));
  double last = servo.run(100).force.written.z;
  EXPECT_NEAR(last, kStiffness * 0.0003, 1e-6);
  ServoObject lower = object;
  lower.pose.position.z -= 0.0002;
  servo.adopt(sceneOf(2, {lower}));
  for (int i = 0; i < 100; ++i) {
    const double now = servo.step().force.written.z;
    EXPECT_LE(std::abs(now - last), kLetIn_N);
    last = now;
  }
  EXPECT_NEAR(last, kStiffness * 0.0001, 1e-6);
}

TEST_F(SurfaceEdit, ThatBringsFrictionBackKnowsNothingOfTheOldStickingPoint) {
  VirtualServo servo(strokeAlongX(0.002, 0.02), kConfig, sceneOf(1, {with(slab(), friction(0.9, 0.9))}));
  servo.run(500);
  servo.adopt(sceneOf(2, {slab()}));
  servo.run(500);
  servo.adopt(sceneOf(3, {with(slab(), friction(0.9, 0.9))}));
  EXPECT_LE(glm::length(servo.step().force.friction), 0.05);
}

TEST_F(SurfaceEdit, OfShadingMakesNoStep) {
  const auto largest = [](bool before, bool after) {
    const ServoObject faceted = objectOf(1, surfaceOf(makeSphere(0.05, 5).value()), Vec3(0));
    const ServoObject round = with(faceted, shading(std::numbers::pi));
    VirtualServo servo(overSphere, kConfig, sceneOf(1, {before ? round : faceted}));
    servo.run(700);
    double most = 0;
    Vec3 last = servo.step().force.written;
    servo.adopt(sceneOf(2, {after ? round : faceted}));
    for (int i = 0; i < 100; ++i) {  // not as far as the next line
      const Vec3 now = servo.step().force.written;
      most = std::max(most, glm::length(now - last));
      last = now;
    }
    return most;
  };
  EXPECT_LE(largest(false, true), largest(true, true) + 0.03);
  EXPECT_LE(largest(true, false), std::max(largest(true, true), largest(false, false)) + 0.03);
}

TEST_F(SurfaceEdit, OfTheMeshKeepsTheStickingPoint) {
  VirtualServo servo(pressThenAside, kConfig, sceneOf(1, {with(slab(), friction(0.9, 0.8))}));
  const TelemetrySample before = servo.run(400);
  const ServoObject finer = objectOf(1, surfaceOf(makeBox(Vec3(0.1), 20).value()), Vec3(0, 0, -0.05));
  servo.adopt(sceneOf(2, {with(finer, friction(0.9, 0.8))}));
  const TelemetrySample after = servo.run(100);
  EXPECT_EQ(after.sceneRevision, 2U);
  EXPECT_EQ(after.frictionState, FrictionState::kSticking);
  EXPECT_LE(glm::distance(after.stickingPoint, before.stickingPoint), 1e-7);
  EXPECT_LE(glm::distance(after.force.friction, before.force.friction), 1e-3);
}

}  // namespace
}  // namespace haptics::surface_edit_tests

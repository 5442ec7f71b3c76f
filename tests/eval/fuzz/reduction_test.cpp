#include <gtest/gtest.h>

#include "tests/eval/fuzz/contact_finding.h"
#include "tests/eval/fuzz/edit_finding.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::eval::reduction_test {
namespace {

FuzzMesh cube() {
  const shapes::Shape shape = shapes::box(Vec3(0.04), 2);
  return {shape.vertices, shape.triangles, {}};
}

/// A HIP that begins in a cube is inside of it whatever the core does.
TEST(Reduction, LeavesOutBodiesAndTicksThatAContactFailureDoesNotNeed) {
  ContactMotion motion{{cube(), cube(), cube()}, {}};
  const Pose at{{1, 0, 0, 0}, Vec3(0)};
  const Pose aside{{1, 0, 0, 0}, Vec3(0.2, 0, 0)};
  motion.frames.assign(300, ContactFrame{Vec3(0.001, 0.002, 0.003), {aside, at, aside}});
  const auto finding = findFailure(motion);
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->failure, ContactFailure::kInside);
  const ContactMotion less = reduced(motion, *finding);
  EXPECT_EQ(less.meshes.size(), 1U);
  EXPECT_LT(less.frames.size(), 30U);
  EXPECT_TRUE(findFailure(less));
}

/// A HIP that does not rest makes a step whatever the core does.
TEST(Reduction, LeavesOutObjectsTicksAndFeaturesThatAStepDoesNotNeed) {
  EditRun run;
  run.device = "falcon";
  run.meshes = {{cube(), std::nullopt}, {cube(), std::nullopt}};
  FuzzObject object;
  object.id = 1;
  object.poseRevision = 1;
  object.stiffness_N_per_m = 1000;
  object.damping_Ns_per_m = 1;
  object.friction = 0.5;
  FuzzObject other = object;
  other.id = 2;
  other.mesh = 1;
  other.pose.position = Vec3(0.2, 0, 0);
  run.scenes = {{0, 1, {object, other}}, {700, 2, {object, other}}};
  run.windows = {{"move", 2, 700, 1700, 1900}};
  for (int tick = 0; tick < 1900; ++tick) {
    const double pressed = tick < 800 ? 0.001 : 0.0015;
    run.hips.emplace_back(0.001, 0.002, 0.021 - (0.001 + pressed) * std::min(1.0, tick / 50.0));
  }
  const auto finding = findFailure(run);
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->failure, EditFailure::kStep);
  const EditRun less = reduced(run, *finding);
  EXPECT_LT(less.hips.size(), 1400U);
  EXPECT_EQ(less.device, "");
  for (const FuzzScene& scene : less.scenes) {
    ASSERT_EQ(scene.objects.size(), 1U);
    EXPECT_EQ(scene.objects.front().friction, 0);
    EXPECT_EQ(scene.objects.front().damping_Ns_per_m, 0);
  }
  const auto again = findFailure(less);
  ASSERT_TRUE(again);
  EXPECT_GT(again->verdict.excess_N, finding->verdict.excess_N / 2);
}

}  // namespace
}  // namespace haptics::eval::reduction_test

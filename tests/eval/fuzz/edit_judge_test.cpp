#include "tests/eval/fuzz/edit_judge.h"

#include <gtest/gtest.h>

#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::eval::edit_judge_test {
namespace {

constexpr double kStiffness_N_per_m = 1000;
constexpr double kHalf_m = 0.02;
constexpr std::uint64_t kBegin = 200;
constexpr std::uint64_t kSettled = 1200;
constexpr std::uint64_t kEnd = 1400;

/// A HIP goes a millimetre into a cube's top and rests; nothing is edited.
EditRun pressed() {
  EditRun run;
  const shapes::Shape shape = shapes::box(Vec3(2 * kHalf_m), 2);
  run.meshes.push_back({{shape.vertices, shape.triangles, {}}, std::nullopt});
  FuzzObject object;
  object.id = 1;
  object.poseRevision = 1;
  object.stiffness_N_per_m = kStiffness_N_per_m;
  run.scenes.push_back({0, 1, {object}});
  run.windows.push_back({"stiffness", 1, kBegin, kSettled, kEnd});
  for (std::uint64_t tick = 0; tick < kEnd; ++tick) {
    run.hips.emplace_back(0.001, 0.002, kHalf_m + 0.001 - 0.002 * std::min(1.0, static_cast<double>(tick) / 50));
  }
  return run;
}

EditRun withStiffness(double stiffness_N_per_m) {
  EditRun run = pressed();
  FuzzScene edited = run.scenes.front();
  edited.tick = kBegin;
  edited.revision = 2;
  edited.objects.front().stiffness_N_per_m = stiffness_N_per_m;
  run.scenes.push_back(edited);
  return run;
}

TEST(EditJudge, FindsNothingWhereNothingHappens) { EXPECT_FALSE(findFailure(pressed())); }

TEST(EditJudge, FindsNothingInAnEditThatIsFeltSlowly) { EXPECT_FALSE(findFailure(withStiffness(1500))); }

TEST(EditJudge, NoticesAStepOfATenthOfANewton) {
  EditRun run = pressed();
  for (std::uint64_t tick = kBegin + 300; tick < kEnd; ++tick) run.hips[tick].z -= 0.1 / kStiffness_N_per_m;
  const auto finding = findFailure(run);
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->failure, EditFailure::kStep);
  EXPECT_NEAR(finding->verdict.step_N, 0.1, 1e-6);
  EXPECT_EQ(finding->verdict.tick, kBegin + 300);
}

TEST(EditJudge, LetsTheForceChangeAsFastAsIsPromised) {
  EditRun run = pressed();
  for (std::uint64_t tick = kBegin + 300; tick < kEnd; ++tick) run.hips[tick].z -= 0.034 / kStiffness_N_per_m;
  EXPECT_FALSE(findFailure(run));
}

TEST(EditJudge, NoticesAnEditThatIsNotFeltInFull) {
  EditRun run = withStiffness(3000);
  run.windows.front().settled = kBegin + 20;  // by then 0.6 N of 2 N
  const auto finding = findFailure(run);
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->failure, EditFailure::kUnfelt);
  EXPECT_NEAR(finding->verdict.missing_N, 2 - 0.6, 0.1);
}

/// An object that leaves cannot be touched anew; the HIP goes into it, and then it is said to stay.
TEST(EditJudge, LooksForTheIhipInsideOfWhatDoesNotLeave) {
  EditRun run = pressed();
  run.scenes.front().objects.front().pendingRemoval = true;
  EXPECT_FALSE(findFailure(run, EditFailure::kInside));
  EditDrive drive(run);
  EditJudge judge(run);
  for (std::uint64_t tick = 0; tick < kBegin; ++tick) drive.step(run.hips[tick]);
  EXPECT_EQ(drive.sample().object, 0U);
  EXPECT_EQ(judge.depth_m(drive), 0);
}

}  // namespace
}  // namespace haptics::eval::edit_judge_test

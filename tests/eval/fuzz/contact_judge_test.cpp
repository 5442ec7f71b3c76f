#include "tests/eval/fuzz/contact_judge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/eval/fuzz/contact_tally.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::eval::contact_judge_test {
namespace {

constexpr double kHalf_m = 0.02;

std::vector<FuzzMesh> cube() {
  const shapes::Shape shape = shapes::box(Vec3(2 * kHalf_m), 2);
  return {{shape.vertices, shape.triangles, {}}};
}

/// A box without its top.
std::vector<FuzzMesh> openBox() {
  FuzzMesh mesh = cube().front();
  std::vector<TriangleIndices> kept;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    (mesh.middleOf(t).z > 0.99 * kHalf_m ? mesh.missing : kept).push_back(mesh.triangles[t]);
  }
  mesh.triangles = kept;
  return {mesh};
}

ContactFrame frameAt(Vec3 hip, Vec3 body = Vec3(0)) { return {hip, {Pose{{1, 0, 0, 0}, body}}}; }

TEST(ContactJudge, NoticesAnIhipThatIsInsideOfACube) {
  ContactJudge judge(cube(), frameAt({0, 0, 0.05}));
  EXPECT_EQ(judge.judge(frameAt({0, 0, 0.015}), {0, 0, 0.02}).inside_m, 0);
  EXPECT_NEAR(judge.judge(frameAt({0, 0, 0.015}), {0, 0, 0.0195}).inside_m, 0.0005, 1e-8);
  EXPECT_NEAR(judge.judge(frameAt({0, 0, 0.015}, {0, 0, 0.001}), {0, 0, 0.02}).inside_m, 0.001, 1e-8);
}

TEST(ContactJudge, NoticesAnIhipThatIsBesideItsExactPlaceOnAFlatTop) {
  ContactJudge judge(cube(), frameAt({0, 0, 0.05}));
  judge.expect({Pose{{1, 0, 0, 0}, {0, 0, kHalf_m}}, Vec3(-kHalf_m), Vec3(kHalf_m)});
  EXPECT_EQ(judge.judge(frameAt({0, 0, 0.021}), {0, 0, 0.021}).aside_m, 0);
  EXPECT_NEAR(judge.judge(frameAt({0.003, 0, 0.019}), {0.0032, 0, 0.02}).aside_m, 0.0002, 1e-12);
  EXPECT_EQ(judge.judge(frameAt({0.0193, 0, 0.019}), {0.02, 0, 0.019}).aside_m, 0) << "the side is as near";
  EXPECT_EQ(judge.judge(frameAt({0, 0, 0.019}), {0.02, 0, 0.019}).aside_m, 0) << "it was not on the top";
}

TEST(ContactJudge, NoticesAnIhipThatIsNotInEquilibrium) {
  constexpr double kOff_m = 3e-4;
  Random random(1);
  const auto isAtRest = [&](Vec3 hip, Vec3 ihip) {
    ContactJudge judge(cube(), frameAt({0, 0, 0.05}));
    const ContactFrame frame = frameAt(hip);
    EXPECT_EQ(judge.judge(frame, ihip).inside_m, 0);
    return judge.isAtRest(frame, kOff_m, random);
  };
  for (int i = 0; i < 50; ++i) {
    const Vec3 hip{random.between(-0.01, 0.01), random.between(-0.01, 0.01), random.between(0.015, 0.018)};
    const double angle = random.between(0, 6.28), aside_m = 1.5 * kOff_m + random.between(0, 0.002);
    const Vec3 above{hip.x, hip.y, kHalf_m};
    EXPECT_TRUE(isAtRest(hip, above)) << i;
    EXPECT_FALSE(isAtRest(hip, above + aside_m * Vec3(std::cos(angle), std::sin(angle), 0))) << i;
  }
  EXPECT_FALSE(isAtRest({0, 0, 0.021}, {0, 0, 0.022})) << "it is held in the air";
  EXPECT_TRUE(isAtRest({kHalf_m + 1e-3, 0, 0.019}, {kHalf_m + 1e-3, 0, 0.019})) << "it is free";
}

TEST(ContactJudge, NoticesAnIhipThatHasPassedAPlate) {
  Random random(3);
  const std::vector<FuzzMesh> plate{makeMesh(MeshKind::kPlate, random)};
  ContactJudge judge(plate, frameAt({0, 0, 0.03}));
  int crossed = 0;
  for (double height_m = 0.03; height_m > -0.03; height_m -= 1e-3)
    crossed += judge.judge(frameAt({0, 0, height_m}), {0, 0, height_m}).crossed ? 1 : 0;
  EXPECT_EQ(crossed, 1);
}

/// A plate comes down on one that is turned over or not: no place, or all the room above the lower one.
TEST(ContactJudge, NoticesAnIhipThatWasPutBeyondAPlateThoughItHadRoom) {
  Random random(3);
  const FuzzMesh plate = makeMesh(MeshKind::kPlate, random);
  for (const bool closes : {false, true}) {
    std::vector<FuzzMesh> plates{plate};
    ContactFrame frame{{0, 0, 0.03}, {Pose{}}};
    if (closes) {
      plates.push_back(plate);
      frame.poses.push_back(Pose{{1, 0, 0, 0}, {0, 0, 0.06}});
    }
    ContactJudge judge(plates, frame);
    if (closes) frame.poses.back().position.z = -0.001;
    const ContactVerdict verdict = judge.judge(frame, {0, 0, -0.03}, true);
    EXPECT_TRUE(verdict.crossed);
    EXPECT_EQ(verdict.hadRoom, !closes);
    ContactWork depenetrated;
    depenetrated.depenetrated = true;
    EXPECT_EQ(ContactRule().apply(verdict, depenetrated).has_value(), !closes);
  }
}

TEST(ContactJudge, NoticesAnIhipThatIsNoNumber) {
  ContactJudge judge(cube(), frameAt({0, 0, 0.05}));
  EXPECT_TRUE(judge.judge(frameAt({0, 0, 0.05}), {0, 0, 0.05}).finite);
  EXPECT_FALSE(judge.judge(frameAt({0, 0, 0.05}), {0, 0, std::numeric_limits<double>::quiet_NaN()}).finite);
}

TEST(ContactJudge, NoticesAnIhipThatGoesThroughASheet) {
  ContactJudge judge(openBox(), frameAt({0, 0, -0.021}));
  EXPECT_FALSE(judge.judge(frameAt({0, 0, -0.0205}), {0, 0, -0.0205}).crossed);
  EXPECT_FALSE(judge.judge(frameAt({0, 0, -0.0195}), {0, 0, -0.02}).crossed);  // held
  EXPECT_TRUE(judge.judge(frameAt({0, 0, -0.0195}), {0, 0, -0.0195}).crossed);
  EXPECT_FALSE(judge.judge(frameAt({0, 0, -0.0195}), {0, 0, -0.0195}).crossed);  // is said once
}

TEST(ContactJudge, NoticesASheetThatGoesThroughAnIhip) {
  ContactJudge judge(openBox(), frameAt({0, 0, -0.021}));
  EXPECT_FALSE(judge.judge(frameAt({0, 0, -0.021}, {0, 0, -0.0005}), {0, 0, -0.021}).crossed);
  EXPECT_TRUE(judge.judge(frameAt({0, 0, -0.021}, {0, 0, -0.0015}), {0, 0, -0.021}).crossed);
}

TEST(ContactJudge, LetsAnIhipGoRoundTheRimOfASheet) {
  ContactJudge judge(openBox(), frameAt({0.021, 0, 0.019}));
  EXPECT_FALSE(judge.judge(frameAt({0.019, 0, 0.0195}), {0.02, 0, 0.0195}).crossed);
  EXPECT_FALSE(judge.judge(frameAt({0.019, 0, 0.0199}), {0.019, 0, 0.0199}).crossed);
  ContactJudge through(openBox(), frameAt({0, 0, 0.03}));
  EXPECT_FALSE(through.judge(frameAt({0, 0, 0.01}), {0, 0, 0.01}).crossed);
}

TEST(ContactJudge, TakesTheSideThatAnIhipWasPutOnAsItIs) {
  for (const bool depenetrated : {false, true}) {
    ContactJudge judge(openBox(), frameAt({0, 0, -0.021}));
    EXPECT_FALSE(judge.judge(frameAt({0, 0, -0.0205}), {0, 0, -0.02}, depenetrated).crossed);
    EXPECT_EQ(judge.judge(frameAt({0, 0, -0.0195}), {0, 0, -0.0195}).crossed, !depenetrated);
  }
}

TEST(ContactRule, FailsATickInsideUnlessItSaysThatItPutTheIhipOutAndTheNextAlways) {
  ContactWork depenetrated;
  depenetrated.depenetrated = true;
  const ContactVerdict inside{.inside_m = 1e-3};
  EXPECT_EQ(ContactRule().apply(inside, {}), ContactFailure::kInside);
  ContactRule rule;
  EXPECT_EQ(rule.apply(inside, depenetrated), std::nullopt);
  EXPECT_EQ(rule.apply(inside, depenetrated), ContactFailure::kInside);
  EXPECT_EQ(rule.apply({}, {}), std::nullopt);
  EXPECT_EQ(rule.insideInARow(), 0);
}

TEST(ContactRule, FailsACrossing) {
  EXPECT_EQ(ContactRule().apply({.crossed = true}, {}), ContactFailure::kCrossing);
  EXPECT_EQ(ContactRule().apply({.finite = false}, {}), ContactFailure::kNotFinite);
}

}  // namespace
}  // namespace haptics::eval::contact_judge_test

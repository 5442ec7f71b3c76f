// What each correction is for, by what is lost without it. The evaluation's failure scenes show the same at large.

#include "haptic_server/contact/corrections.h"

#include <gtest/gtest.h>

#include "haptic_server/contact/contact_tick.h"
#include "tests/haptic_server/contact/world.h"

namespace haptics::corrections_test {
namespace {

/// A HIP with some corrections, beside the production step, among the same bodies.
class Apprentice {
 public:
  Apprentice(const Corrections& corrections, World& world, Vec3 hip) : corrections_(corrections), world_(world) {
    world_.place(hip);
    resetContact(state_, hip);
  }
  ContactResult tick(Vec3 hip) {
    for (Body& body : world_.bodies()) body.update();
    ContactResult result;
    followGuarded(world_.bodies(), state_, hip, result, corrections_);
    full_ = world_.tick(hip);
    return result;
  }
  [[nodiscard]] const ContactResult& full() const { return full_; }

 private:
  Corrections corrections_;
  World& world_;
  ContactState state_;
  ContactResult full_;
};

TEST(Corrections, WithAllOfThemTheGeneralPathIsTheProductionStep) {
  World world;
  world.add(shapes::sphere(0.05, 8));
  world.add(shapes::sphere(0.03, 8), Vec3(0.06, 0, 0));
  Apprentice all(kAllCorrections, world, {0, 0, 0.06});
  for (int i = 0; i < 400; ++i) {
    const ContactResult r = all.tick({0.0002 * i, 0.003, 0.06 - 0.0004 * std::min(i, 100)});
    ASSERT_EQ(r.ihip, all.full().ihip) << i;
    ASSERT_EQ(r.touching, all.full().touching) << i;
  }
}

constexpr Corrections kWithoutFeatureCodes{.featureCodes = false};
TEST(Corrections, WithoutFeatureCodesTheIhipNeverLeavesItsFirstPolygon) {
  World world(shapes::box({0.1, 0.1, 0.1}, 4));
  Apprentice printed(kWithoutFeatureCodes, world, {0, 0.003, 0.051});
  ContactResult r;
  for (int i = 0; i < 100; ++i) r = printed.tick({0.0004 * i, 0.003, 0.049});
  EXPECT_GT(glm::distance(r.ihip, printed.full().ihip), 0.01);
}

constexpr Corrections kWithoutPseudonormals{.pseudonormals = false};
/// Of a hand so fast that steps do not divide its motion.
bool isHeldBeyondATip(Corrections corrections) {
  corrections.substeps = false;
  World world(shapes::cone(0.01, 0.05, 5));
  Apprentice pricked(corrections, world, {0.004, 0.0003, 0.046});
  EXPECT_TRUE(pricked.tick({0.0002, 0.0003, 0.045}).touching);
  return pricked.tick({-0.001, 0.0003, 0.051}).touching;
}
TEST(Corrections, WithoutPseudonormalsASpikesTipHoldsAHipThatIsBeyondIt) {
  EXPECT_FALSE(isHeldBeyondATip(kAllCorrections));
  EXPECT_TRUE(isHeldBeyondATip(kWithoutPseudonormals));
}

constexpr Corrections kWithoutSameTickSearch{.sameTickSearch = false};
TEST(Corrections, WithoutTheSameTickSearchTheFirstForceIsATickLate) {
  World world(shapes::box({0.1, 0.1, 0.1}, 4));
  Apprentice late(kWithoutSameTickSearch, world, {0.01, 0.003, 0.051});
  EXPECT_FALSE(late.tick({0.01, 0.003, 0.048}).touching);
  EXPECT_TRUE(late.full().touching);
  const ContactResult next = late.tick({0.01, 0.003, 0.048});
  EXPECT_TRUE(next.touching);
  EXPECT_NEAR(glm::distance(next.ihip, late.full().ihip), 0, 1e-12);
}

constexpr Corrections kWithoutExitRetest{.exitRetest = false};
TEST(Corrections, WithoutTheExitRetestTheHipFallsIntoTheNextBody) {
  World world;
  world.add(shapes::box({0.02, 0.02, 0.02}, 1));
  world.add(shapes::box({0.02, 0.02, 0.02}, 1), Vec3(0.0205, 0, 0));
  Apprentice combed(kWithoutExitRetest, world, {0.0101, 0.001, 0.009});
  (void)combed.tick({0.0097, 0.001, 0.009});
  EXPECT_TRUE(combed.full().touching);
  const ContactResult r = combed.tick({0.0112, 0.001, 0.0085});
  EXPECT_FALSE(r.touching);
  EXPECT_TRUE(combed.full().touching);
}

constexpr Corrections kWithoutObjectFrames{.objectFrameSegments = false};
TEST(Corrections, WithoutObjectFramesABoxRisesThroughAStillHip) {
  World world;
  const int box = world.add(shapes::box({0.1, 0.1, 0.1}, 4));
  const Vec3 hip{0.011, 0.003, 0.051};
  Apprentice blind(kWithoutObjectFrames, world, hip);
  world.move(box, {{1, 0, 0, 0}, {0, 0, 0.004}});
  EXPECT_FALSE(blind.tick(hip).touching);
  EXPECT_TRUE(blind.full().touching);
}

constexpr Corrections kWithoutGuard{.guard = false};
constexpr Corrections kWithOneSurface{.severalSurfaces = false};
ContactResult slideIntoAWall(World& world, const Corrections& corrections) {
  world.add(shapes::box({0.2, 0.2, 0.02}, 4));
  world.add(shapes::box({0.04, 0.04, 0.04}, 2), Vec3(0.05, 0, 0.02));
  Apprentice hand(corrections, world, {0, 0.003, 0.012});
  ContactResult r;
  for (int i = 0; i < 80; ++i) r = hand.tick({0.0005 * i, 0.003 + 0.0001 * i, 0.008});
  EXPECT_EQ(world.depthInside(hand.full().ihip), 0);
  EXPECT_NEAR(hand.full().ihip.x, 0.03, 1e-6);
  EXPECT_NEAR(hand.full().ihip.y, 0.0109, 1e-6);
  return r;
}
TEST(Corrections, WithoutTheGuardTheIhipEntersAnotherBody) {
  World world;
  EXPECT_GT(world.depthInside(slideIntoAWall(world, kWithoutGuard).ihip), 0.001);
}
TEST(Corrections, WithOneSurfaceABlockedIhipDoesNotSlideAlongTheWall) {
  World world;
  const ContactResult r = slideIntoAWall(world, kWithOneSurface);
  EXPECT_EQ(world.depthInside(r.ihip), 0);
  EXPECT_LT(r.ihip.y, 0.01);
}

constexpr Corrections kWithoutABudget{.boundedSearch = false};
TEST(Corrections, WithoutABudgetATickLooksAtMore) {
  const auto looked = [](const Corrections& corrections) {
    World world(shapes::cone(0.05, 0.02, 8 * kSearchBudget));
    Apprentice hand(corrections, world, {0.001, 0.0003, 0.0201});
    return hand.tick({-0.0001, 0, 0.019}).work.triangles;
  };
  EXPECT_LT(looked(kAllCorrections), 2 * kSearchBudget);
  EXPECT_GT(looked(kWithoutABudget), 3 * kSearchBudget);
}
constexpr Corrections kWithoutSubsteps{.substeps = false};
TEST(Corrections, WithoutSubstepsATickIsOneStep) {
  World world(shapes::sphere(0.05, 100));
  Apprentice leaping(kWithoutSubsteps, world, {0, 0, 0.051});
  (void)leaping.tick({0, 0, 0.049});
  EXPECT_EQ(leaping.tick({0.005, 0, 0.049}).work.steps, 1);
  EXPECT_GT(leaping.full().work.steps, 1);
}

constexpr Corrections kWithAbsoluteTolerances{.scaleFreeTolerances = false};
TEST(Corrections, WithAbsoluteTolerancesTheResultDependsOnTheUnit) {
  const auto corner = [](const Corrections& corrections, double scale) {
    World world;
    world.add(shapes::box(Vec3(0.2, 0.2, 0.02) * scale, 4));
    world.add(shapes::box(Vec3(0.04, 0.04, 0.04) * scale, 2), Vec3(0.05, 0, 0.02) * scale);
    Apprentice hand(corrections, world, Vec3(0, 0.003, 0.012) * scale);
    ContactResult r;
    for (int i = 0; i < 80; ++i) r = hand.tick(Vec3(0.0005 * i, 0.003, 0.008) * scale);
    return r.ihip / scale;
  };
  EXPECT_EQ(corner(kAllCorrections, 0x1p-10), corner(kAllCorrections, 1));
  EXPECT_NE(corner(kWithAbsoluteTolerances, 0x1p-10), corner(kWithAbsoluteTolerances, 1));
}

bool entersNothing(Vec3, Vec3, const TriangleRecord&, bool, Crossing&) noexcept { return false; }
TEST(Corrections, TheSegmentTestIsTheOneThatIsNamed) {
  World world(shapes::box({0.1, 0.1, 0.1}, 4));
  Apprentice blind({.segmentTest = entersNothing}, world, {0.01, 0.003, 0.051});
  EXPECT_FALSE(blind.tick({0.01, 0.003, 0.048}).touching);
  EXPECT_TRUE(blind.full().touching);
}

/// A millimetre too high.
ClosestPoint highFoot(const TriangleRecord& record, std::uint32_t triangle, Vec3 h) noexcept {
  ClosestPoint foot = closestOn(record, triangle, h);
  foot.point.z += 0.001;
  return foot;
}
TEST(Corrections, TheSearchsClosestPointIsOfTheOneThatIsNamed) {
  World world(shapes::box({0.1, 0.1, 0.1}, 4));
  Apprentice high({.regionSteps = false, .closestPoint = highFoot}, world, {0.01, 0.003, 0.051});
  EXPECT_NEAR(high.tick({0.01, 0.003, 0.048}).ihip.z, 0.051, 1e-9);
}

}  // namespace
}  // namespace haptics::corrections_test

// What fails without each correction. The evaluation's failure scenes show the same at large.

#include "haptic_server/engine/contact/corrections.h"

#include <gtest/gtest.h>

#include "haptic_server/engine/contact/contact_tick.h"
#include "tests/haptic_server/engine/contact/contact_rig.h"

namespace haptics::corrections_test {
namespace {

/// A contact with some corrections off beside one with all, among the same bodies.
class AblatedContact {
 public:
  AblatedContact(const Corrections& corrections, ContactRig& world, Vec3 hip)
      : corrections_(corrections), world_(world) {
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
  ContactRig& world_;
  ContactState state_;
  ContactResult full_;
};

TEST(Corrections, AllOnGiveTheResultOfFollowContact) {
  ContactRig world;
  world.add(shapes::sphere(0.05, 8));
  world.add(shapes::sphere(0.03, 8), Vec3(0.06, 0, 0));
  AblatedContact all(kAllCorrections, world, {0, 0, 0.06});
  for (int i = 0; i < 400; ++i) {
    const ContactResult r = all.tick({0.0002 * i, 0.003, 0.06 - 0.0004 * std::min(i, 100)});
    ASSERT_EQ(r.ihip, all.full().ihip) << i;
    ASSERT_EQ(r.touching, all.full().touching) << i;
  }
}

constexpr Corrections kWithoutFeatureCodes{.featureCodes = false};
TEST(Corrections, WithoutFeatureCodesTheSearchStaysOnItsFirstPolygon) {
  ContactRig world(shapes::box({0.1, 0.1, 0.1}, 4));
  AblatedContact ablated(kWithoutFeatureCodes, world, {0, 0.003, 0.051});
  ContactResult r;
  for (int i = 0; i < 100; ++i) r = ablated.tick({0.0004 * i, 0.003, 0.049});
  EXPECT_GT(glm::distance(r.ihip, ablated.full().ihip), 0.01);
}

constexpr Corrections kWithoutPseudonormals{.pseudonormals = false};
/// Of a hand so fast that steps do not divide its motion.
bool isHeldBeyondATip(Corrections corrections) {
  corrections.substeps = false;
  ContactRig world(shapes::cone(0.01, 0.05, 5));
  AblatedContact ablated(corrections, world, {0.004, 0.0003, 0.046});
  EXPECT_TRUE(ablated.tick({0.0002, 0.0003, 0.045}).touching);
  return ablated.tick({-0.001, 0.0003, 0.051}).touching;
}
TEST(Corrections, WithoutPseudonormalsATipHoldsAHipOutside) {
  EXPECT_FALSE(isHeldBeyondATip(kAllCorrections));
  EXPECT_TRUE(isHeldBeyondATip(kWithoutPseudonormals));
}

constexpr Corrections kWithoutSameTickSearch{.sameTickSearch = false};
TEST(Corrections, WithoutSameTickSearchTheFirstForceIsATickLate) {
  ContactRig world(shapes::box({0.1, 0.1, 0.1}, 4));
  AblatedContact ablated(kWithoutSameTickSearch, world, {0.01, 0.003, 0.051});
  EXPECT_FALSE(ablated.tick({0.01, 0.003, 0.048}).touching);
  EXPECT_TRUE(ablated.full().touching);
  const ContactResult next = ablated.tick({0.01, 0.003, 0.048});
  EXPECT_TRUE(next.touching);
  EXPECT_NEAR(glm::distance(next.ihip, ablated.full().ihip), 0, 1e-12);
}

constexpr Corrections kWithoutExitRetest{.exitRetest = false};
TEST(Corrections, WithoutExitRetestTheHipEntersTheNextBody) {
  ContactRig world;
  world.add(shapes::box({0.02, 0.02, 0.02}, 1));
  world.add(shapes::box({0.02, 0.02, 0.02}, 1), Vec3(0.0205, 0, 0));
  AblatedContact ablated(kWithoutExitRetest, world, {0.0101, 0.001, 0.009});
  (void)ablated.tick({0.0097, 0.001, 0.009});
  EXPECT_TRUE(ablated.full().touching);
  const ContactResult r = ablated.tick({0.0112, 0.001, 0.0085});
  EXPECT_FALSE(r.touching);
  EXPECT_TRUE(ablated.full().touching);
}

constexpr Corrections kWithoutObjectFrames{.objectFrameSegments = false};
TEST(Corrections, WithoutObjectFramesARisingBoxIsNotTouched) {
  ContactRig world;
  const int box = world.add(shapes::box({0.1, 0.1, 0.1}, 4));
  const Vec3 hip{0.011, 0.003, 0.051};
  AblatedContact ablated(kWithoutObjectFrames, world, hip);
  world.move(box, {{1, 0, 0, 0}, {0, 0, 0.004}});
  EXPECT_FALSE(ablated.tick(hip).touching);
  EXPECT_TRUE(ablated.full().touching);
}

constexpr Corrections kWithoutGuard{.guard = false};
constexpr Corrections kWithOneSurface{.severalSurfaces = false};
ContactResult slideIntoAWall(ContactRig& world, const Corrections& corrections) {
  world.add(shapes::box({0.2, 0.2, 0.02}, 4));
  world.add(shapes::box({0.04, 0.04, 0.04}, 2), Vec3(0.05, 0, 0.02));
  AblatedContact ablated(corrections, world, {0, 0.003, 0.012});
  ContactResult r;
  for (int i = 0; i < 80; ++i) r = ablated.tick({0.0005 * i, 0.003 + 0.0001 * i, 0.008});
  EXPECT_EQ(world.depthInside(ablated.full().ihip), 0);
  EXPECT_NEAR(ablated.full().ihip.x, 0.03, 1e-6);
  EXPECT_NEAR(ablated.full().ihip.y, 0.0109, 1e-6);
  return r;
}
TEST(Corrections, WithoutGuardTheIhipEntersAnotherBody) {
  ContactRig world;
  EXPECT_GT(world.depthInside(slideIntoAWall(world, kWithoutGuard).ihip), 0.001);
}
TEST(Corrections, WithoutSeveralSurfacesABlockedIhipStays) {
  ContactRig world;
  const ContactResult r = slideIntoAWall(world, kWithOneSurface);
  EXPECT_EQ(world.depthInside(r.ihip), 0);
  EXPECT_LT(r.ihip.y, 0.01);
}

constexpr Corrections kWithoutABudget{.boundedSearch = false};
TEST(Corrections, WithoutBudgetASearchIsUnbounded) {
  const auto looked = [](const Corrections& corrections) {
    ContactRig world(shapes::cone(0.05, 0.02, 8 * kSearchBudget));
    AblatedContact ablated(corrections, world, {0.001, 0.0003, 0.0201});
    return ablated.tick({-0.0001, 0, 0.019}).work.triangles;
  };
  EXPECT_LT(looked(kAllCorrections), 2 * kSearchBudget);
  EXPECT_GT(looked(kWithoutABudget), 3 * kSearchBudget);
}
constexpr Corrections kWithoutSubsteps{.substeps = false};
TEST(Corrections, WithoutSubstepsATickIsOneStep) {
  ContactRig world(shapes::sphere(0.05, 100));
  AblatedContact ablated(kWithoutSubsteps, world, {0, 0, 0.051});
  (void)ablated.tick({0, 0, 0.049});
  EXPECT_EQ(ablated.tick({0.005, 0, 0.049}).work.steps, 1);
  EXPECT_GT(ablated.full().work.steps, 1);
}

constexpr Corrections kWithAbsoluteTolerances{.scaleFreeTolerances = false};
TEST(Corrections, WithoutScaleFreeTolerancesTheResultDependsOnTheUnit) {
  const auto corner = [](const Corrections& corrections, double scale) {
    ContactRig world;
    world.add(shapes::box(Vec3(0.2, 0.2, 0.02) * scale, 4));
    world.add(shapes::box(Vec3(0.04, 0.04, 0.04) * scale, 2), Vec3(0.05, 0, 0.02) * scale);
    AblatedContact ablated(corrections, world, Vec3(0, 0.003, 0.012) * scale);
    ContactResult r;
    for (int i = 0; i < 80; ++i) r = ablated.tick(Vec3(0.0005 * i, 0.003, 0.008) * scale);
    return r.ihip / scale;
  };
  EXPECT_EQ(corner(kAllCorrections, 0x1p-10), corner(kAllCorrections, 1));
  EXPECT_NE(corner(kWithAbsoluteTolerances, 0x1p-10), corner(kWithAbsoluteTolerances, 1));
}

bool entersNothing(Vec3, Vec3, const TriangleRecord&, bool, Crossing&) noexcept { return false; }
TEST(Corrections, SegmentTestIsReplaceable) {
  ContactRig world(shapes::box({0.1, 0.1, 0.1}, 4));
  AblatedContact ablated({.segmentTest = entersNothing}, world, {0.01, 0.003, 0.051});
  EXPECT_FALSE(ablated.tick({0.01, 0.003, 0.048}).touching);
  EXPECT_TRUE(ablated.full().touching);
}

/// A millimetre too ablated.
ClosestPoint highFoot(const TriangleRecord& record, std::uint32_t triangle, Vec3 h) noexcept {
  ClosestPoint foot = closestOn(record, triangle, h);
  foot.point.z += 0.001;
  return foot;
}
TEST(Corrections, ClosestPointIsReplaceable) {
  ContactRig world(shapes::box({0.1, 0.1, 0.1}, 4));
  AblatedContact ablated({.regionSteps = false, .closestPoint = highFoot}, world, {0.01, 0.003, 0.051});
  EXPECT_NEAR(ablated.tick({0.01, 0.003, 0.048}).ihip.z, 0.051, 1e-9);
}

}  // namespace
}  // namespace haptics::corrections_test

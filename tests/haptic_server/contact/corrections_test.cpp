// What each correction is for, by what is lost without it. The evaluation's failure scenes show the same at large.

#include "haptic_server/contact/corrections.h"

#include <gtest/gtest.h>

#include "haptic_server/contact/contact_tick_impl.h"
#include "tests/haptic_server/contact/world.h"

namespace haptics {
namespace {

/// A HIP under a policy, beside the production step, among the same bodies.
template <class Corrections>
class Apprentice {
 public:
  Apprentice(World& world, Vec3 hip) : world_(world) {
    world_.place(hip);
    place(state_, hip);
  }
  ContactResult tick(Vec3 hip) {
    for (Body& body : world_.bodies()) body.update();
    const ContactResult result = followContact<Corrections>(world_.bodies(), state_, hip);
    full_ = world_.tick(hip);
    return result;
  }
  [[nodiscard]] const ContactResult& full() const { return full_; }

 private:
  World& world_;
  ContactState state_;
  ContactResult full_;
};

TEST(Corrections, WithAllOfThemThePolicyIsTheProductionStep) {
  World world;
  world.add(shapes::sphere(0.05, 8));
  world.add(shapes::sphere(0.03, 8), Vec3(0.06, 0, 0));
  Apprentice<AllCorrections> all(world, {0, 0, 0.06});
  for (int i = 0; i < 400; ++i) {
    const ContactResult r = all.tick({0.0002 * i, 0.003, 0.06 - 0.0004 * std::min(i, 100)});
    ASSERT_EQ(r.ihip, all.full().ihip) << i;
    ASSERT_EQ(r.touching, all.full().touching) << i;
  }
}

struct WithoutFeatureCodes : AllCorrections {
  static constexpr bool kFeatureCodes = false;
};
TEST(Corrections, WithoutFeatureCodesTheIhipNeverLeavesItsFirstPolygon) {
  World world;
  world.add(shapes::box({0.1, 0.1, 0.1}, 4));
  Apprentice<WithoutFeatureCodes> printed(world, {0, 0.003, 0.051});
  ContactResult r;
  for (int i = 0; i < 100; ++i) r = printed.tick({0.0004 * i, 0.003, 0.049});
  EXPECT_GT(glm::distance(r.ihip, printed.full().ihip), 0.01);
}

struct WithoutPseudonormals : AllCorrections {
  static constexpr bool kPseudonormals = false;
};
/// A hand so fast that steps do not divide its motion.
template <class Corrections>
struct InOneStep : Corrections {
  static constexpr bool kSubsteps = false;
};
template <class Corrections>
bool isHeldBeyondATip() {
  World world;
  world.add(shapes::cone(0.01, 0.05, 5));
  Apprentice<InOneStep<Corrections>> pricked(world, {0.004, 0.0003, 0.046});
  EXPECT_TRUE(pricked.tick({0.0002, 0.0003, 0.045}).touching);
  return pricked.tick({-0.001, 0.0003, 0.051}).touching;
}
TEST(Corrections, WithoutPseudonormalsASpikesTipHoldsAHipThatIsBeyondIt) {
  EXPECT_FALSE(isHeldBeyondATip<AllCorrections>());
  EXPECT_TRUE(isHeldBeyondATip<WithoutPseudonormals>());
}

struct WithoutSameTickSearch : AllCorrections {
  static constexpr bool kSameTickSearch = false;
};
TEST(Corrections, WithoutTheSameTickSearchTheFirstForceIsATickLate) {
  World world;
  world.add(shapes::box({0.1, 0.1, 0.1}, 4));
  Apprentice<WithoutSameTickSearch> late(world, {0.01, 0.003, 0.051});
  EXPECT_FALSE(late.tick({0.01, 0.003, 0.048}).touching);
  EXPECT_TRUE(late.full().touching);
  const ContactResult next = late.tick({0.01, 0.003, 0.048});
  EXPECT_TRUE(next.touching);
  EXPECT_NEAR(glm::distance(next.ihip, late.full().ihip), 0, 1e-12);
}

struct WithoutExitRetest : AllCorrections {
  static constexpr bool kExitRetest = false;
};
TEST(Corrections, WithoutTheExitRetestTheHipFallsIntoTheNextBody) {
  World world;
  world.add(shapes::box({0.02, 0.02, 0.02}, 1));
  world.add(shapes::box({0.02, 0.02, 0.02}, 1), Vec3(0.0205, 0, 0));
  Apprentice<WithoutExitRetest> combed(world, {0.0101, 0.001, 0.009});
  (void)combed.tick({0.0097, 0.001, 0.009});
  EXPECT_TRUE(combed.full().touching);
  const ContactResult r = combed.tick({0.0112, 0.001, 0.0085});
  EXPECT_FALSE(r.touching);
  EXPECT_TRUE(combed.full().touching);
}

struct WithoutObjectFrames : AllCorrections {
  static constexpr bool kObjectFrameSegments = false;
};
TEST(Corrections, WithoutObjectFramesABoxRisesThroughAStillHip) {
  World world;
  const int box = world.add(shapes::box({0.1, 0.1, 0.1}, 4));
  const Vec3 hip{0.011, 0.003, 0.051};
  Apprentice<WithoutObjectFrames> blind(world, hip);
  world.move(box, {{1, 0, 0, 0}, {0, 0, 0.004}});
  EXPECT_FALSE(blind.tick(hip).touching);
  EXPECT_TRUE(blind.full().touching);
}

struct WithoutGuard : AllCorrections {
  static constexpr bool kGuard = false;
};
struct WithOneSurface : AllCorrections {
  static constexpr bool kSeveralSurfaces = false;
};
template <class Corrections>
ContactResult slideIntoAWall(World& world) {
  world.add(shapes::box({0.2, 0.2, 0.02}, 4));
  world.add(shapes::box({0.04, 0.04, 0.04}, 2), Vec3(0.05, 0, 0.02));
  Apprentice<Corrections> hand(world, {0, 0.003, 0.012});
  ContactResult r;
  for (int i = 0; i < 80; ++i) r = hand.tick({0.0005 * i, 0.003 + 0.0001 * i, 0.008});
  EXPECT_EQ(world.depthInside(hand.full().ihip), 0);
  EXPECT_NEAR(hand.full().ihip.x, 0.03, 1e-6);
  EXPECT_NEAR(hand.full().ihip.y, 0.0109, 1e-6);
  return r;
}
TEST(Corrections, WithoutTheGuardTheIhipEntersAnotherBody) {
  World world;
  EXPECT_GT(world.depthInside(slideIntoAWall<WithoutGuard>(world).ihip), 0.001);
}
TEST(Corrections, WithOneSurfaceABlockedIhipDoesNotSlideAlongTheWall) {
  World world;
  const ContactResult r = slideIntoAWall<WithOneSurface>(world);
  EXPECT_EQ(world.depthInside(r.ihip), 0);
  EXPECT_LT(r.ihip.y, 0.01);
}

struct WithoutABudget : AllCorrections {
  static constexpr bool kBoundedSearch = false;
};
TEST(Corrections, WithoutABudgetATickLooksAtMore) {
  const auto looked = [](auto corrections) {
    World world;
    world.add(shapes::cone(0.05, 0.02, 8 * kSearchBudget));
    Apprentice<decltype(corrections)> hand(world, {0.001, 0.0003, 0.0201});
    return hand.tick({-0.0001, 0, 0.019}).work.triangles;
  };
  EXPECT_LT(looked(AllCorrections{}), 2 * kSearchBudget);
  EXPECT_GT(looked(WithoutABudget{}), 3 * kSearchBudget);
}
struct WithoutSubsteps : AllCorrections {
  static constexpr bool kSubsteps = false;
};
TEST(Corrections, WithoutSubstepsATickIsOneStep) {
  World world;
  world.add(shapes::sphere(0.05, 100));
  Apprentice<WithoutSubsteps> leaping(world, {0, 0, 0.051});
  (void)leaping.tick({0, 0, 0.049});
  EXPECT_EQ(leaping.tick({0.005, 0, 0.049}).work.steps, 1);
  EXPECT_GT(leaping.full().work.steps, 1);
}

struct WithAbsoluteTolerances : AllCorrections {
  static constexpr bool kScaleFreeTolerances = false;
};
TEST(Corrections, WithAbsoluteTolerancesTheResultDependsOnTheUnit) {
  const auto corner = [](auto corrections, double scale) {
    World world;
    world.add(shapes::box(Vec3(0.2, 0.2, 0.02) * scale, 4));
    world.add(shapes::box(Vec3(0.04, 0.04, 0.04) * scale, 2), Vec3(0.05, 0, 0.02) * scale);
    Apprentice<decltype(corrections)> hand(world, Vec3(0, 0.003, 0.012) * scale);
    ContactResult r;
    for (int i = 0; i < 80; ++i) r = hand.tick(Vec3(0.0005 * i, 0.003, 0.008) * scale);
    return r.ihip / scale;
  };
  EXPECT_EQ(corner(AllCorrections{}, 0x1p-10), corner(AllCorrections{}, 1));
  EXPECT_NE(corner(WithAbsoluteTolerances{}, 0x1p-10), corner(WithAbsoluteTolerances{}, 1));
}

/// Enters nothing.
struct BlindSegment {
  BlindSegment(Vec3, Vec3) noexcept {}
  [[nodiscard]] bool enters(const TriangleRecord&, bool, Crossing&) const noexcept { return false; }
};
struct WithBlindSegments : AllCorrections {
  using SegmentTest = BlindSegment;
};
TEST(Corrections, TheSegmentTestIsThePolicys) {
  World world;
  world.add(shapes::box({0.1, 0.1, 0.1}, 4));
  Apprentice<WithBlindSegments> blind(world, {0.01, 0.003, 0.051});
  EXPECT_FALSE(blind.tick({0.01, 0.003, 0.048}).touching);
  EXPECT_TRUE(blind.full().touching);
}

/// Every closest point a millimetre too high.
struct WithHighFeet : AllCorrections {
  static constexpr bool kRegionSteps = false;
  [[nodiscard]] static Foot closestPoint(const TriangleRecord& record, std::uint32_t triangle, Vec3 h) noexcept {
    Foot foot = closestOn(record, triangle, h);
    foot.point.z += 0.001;
    return foot;
  }
};
TEST(Corrections, TheSearchsClosestPointIsThePolicys) {
  World world;
  world.add(shapes::box({0.1, 0.1, 0.1}, 4));
  Apprentice<WithHighFeet> high(world, {0.01, 0.003, 0.051});
  EXPECT_NEAR(high.tick({0.01, 0.003, 0.048}).ihip.z, 0.051, 1e-9);
}

}  // namespace
}  // namespace haptics

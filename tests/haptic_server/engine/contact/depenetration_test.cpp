// Depenetration of an IHIP that moving bodies close in on.

#include "haptic_server/engine/contact/depenetration.h"

#include <gtest/gtest.h>

#include <random>

#include "haptic_server/engine/contact/neighborhood_watch.h"
#include "tests/haptic_server/engine/contact/contact_rig.h"

namespace haptics::depenetration_test {
namespace {

constexpr double kSkin_m = 1e-7;

Vec3 depenetrated(ContactRig& world, Vec3 from, Vec3 outward) {
  for (Body& body : world.bodies()) body.update();
  ContactWork work;
  const Vec3 out = findDepenetration(world.bodies(), NearBodies(), from, outward, kSkin_m, work).value();
  EXPECT_LT(work.triangles, kMaxDepenetrationTriangles + kSearchBudget);
  EXPECT_LT(work.segments, kMaxDepenetrationSegments + 3 * static_cast<int>(world.bodies().size()));
  return out;
}

TEST(Depenetration, LeavesAPointOutsideInPlace) {
  ContactRig world;
  world.add(shapes::sphere(0.05, 8));
  world.add(shapes::sheet(0.2, 4));  // has no inside
  const Vec3 at{0, 0.06, -0.001};
  EXPECT_EQ(depenetrated(world, at, {0, 0, 1}), at);
}

TEST(Depenetration, TakesTheNearestPointAboveThePlanesOfAnOpenWedge) {
  ContactRig world;
  world.add(shapes::box({0.2, 0.2, 0.02}, 4), Vec3(0, 0, -0.01));
  world.add(shapes::box({0.02, 0.2, 0.2}, 4), Vec3(-0.01, 0, 0));
  const Vec3 out = depenetrated(world, {-0.0002, 0.003, -0.0001}, {0, 0, 1});
  EXPECT_NEAR(glm::distance(out, Vec3(kSkin_m, 0.003, kSkin_m)), 0, 1e-8);
}

TEST(Depenetration, PassesThroughABodyWhereNoSideIsOpen) {
  ContactRig world;
  world.add(shapes::box({0.2, 0.2, 0.1}, 4), Vec3(0, 0, -0.05));
  world.add(shapes::box({0.2, 0.2, 0.004}, 4), Vec3(0, 0, 0.002 - 0.0001));  // a plate that sank into it
  const Vec3 out = depenetrated(world, {0.003, 0.002, -0.00005}, {0, 0, 1});
  EXPECT_NEAR(out.x, 0.003, 1e-9);
  EXPECT_NEAR(out.y, 0.002, 1e-9);
  EXPECT_NEAR(out.z, 0.0039 + kSkin_m, 1e-8);
}

TEST(Depenetration, LeavesRandomOverlappingBodies) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> within(-0.03, 0.03);
  const auto somewhere = [&] { return Vec3(within(random), within(random), within(random)); };
  for (int i = 0; i < 200; ++i) {
    ContactRig world;
    world.add(shapes::bumpy(0.03, 8), somewhere());
    world.add(shapes::torus(0.03, 0.012, 24, 12), somewhere());
    world.add(shapes::box({0.06, 0.04, 0.03}, 2), Pose{glm::angleAxis(1.0, Vec3(0.6, 0, 0.8)), somewhere()});
    world.add(shapes::box({0.08, 0.08, 0.001}, 2), Pose{glm::angleAxis(0.3, Vec3(0, 0.6, 0.8)), somewhere()});
    const Vec3 from = somewhere();
    const Vec3 out = depenetrated(world, from, glm::normalize(somewhere()));
    ASSERT_EQ(world.depthInside(out), 0) << i;
    if (world.depthInside(from) == 0) {
      EXPECT_EQ(out, from);
    }
  }
}

/// More than may be looked at in a tick.
TEST(Depenetration, LeavesFineBodiesWithinItsBudget) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> within(-0.01, 0.01);
  const auto somewhere = [&] { return Vec3(within(random), within(random), within(random)); };
  const auto ball = shapes::sphere(0.03, 48).build();
  const auto ring = shapes::torus(0.03, 0.02, 160, 80).build();
  for (int i = 0; i < 20; ++i) {
    ContactRig world;
    for (int k = 0; k < 6; ++k) {
      world.add(ball, {{1, 0, 0, 0}, somewhere()});
      world.add(ring, {glm::angleAxis(0.7 * k, Vec3(0.6, 0, 0.8)), somewhere()});
    }
    const Vec3 from = 0.3 * somewhere();
    const Vec3 out = depenetrated(world, from, glm::normalize(somewhere()));
    ASSERT_GT(world.depthInside(from), 0) << i;
    EXPECT_EQ(world.depthInside(out), 0) << i;
    EXPECT_LT(glm::distance(out, from), 0.12) << i;
  }
}

/// Two walls on a floor come together over an IHIP between them, and pass through each other.
TEST(Depenetration, FreesAnIhipInAClosingPocket) {
  constexpr double kTouchable = 6e-7;  // m
  ContactRig world;
  world.add(shapes::box({0.3, 0.3, 0.1}, 4), Vec3(0, 0, -0.05));
  const int left = world.add(shapes::box({0.04, 0.1, 0.04}, 2), Vec3(-0.03, 0, 0));
  const int right = world.add(shapes::box({0.04, 0.1, 0.04}, 2), Vec3(0.03, 0, 0));
  const Vec3 hip{0.001, 0.003, -0.003};
  world.place({0.001, 0.003, 0.001});
  world.tick(hip);
  int timesPutOut = 0;
  for (int i = 1; i <= 60; ++i) {
    const double inner = 0.03 - 0.0003 * i;
    world.move(left, {{1, 0, 0, 0}, {-inner, 0, 0}});
    world.move(right, {{1, 0, 0, 0}, {inner, 0, 0}});
    const ContactResult r = world.tick(hip);
    EXPECT_TRUE(r.touching) << i;
    EXPECT_LT(world.depthInside(r.ihip), kTouchable) << i;
    timesPutOut += r.work.depenetrated ? 1 : 0;
  }
  EXPECT_EQ(timesPutOut, 1);
  EXPECT_NEAR(world.result().ihip.z, 0.02, kTouchable);  // on top of the walls
}

/// A plate of 10 um comes down into a groove, in steps that are longer than it is thick, on an IHIP that is held at the bottom.
TEST(Depenetration, NoThinPlatePassesTheIhipUnsaid) {
  ContactRig world;
  for (const double side : {-1.0, 1.0}) {
    const Quat turn = glm::angleAxis(side * 0.3, Vec3(0, 1, 0));
    world.add(shapes::box({0.2, 0.2, 0.1}, 4), Pose{turn, turn * Vec3(-side * 0.1, 0, -0.05)});
  }
  const int plate = world.add(shapes::box({0.3, 0.3, 1e-5}, 4), Vec3(0, 0, 0.004));
  const Vec3 hip{0, 0.003, -0.003};
  world.place({0, 0.003, 0.001});
  world.tick(hip);
  bool wasSaid = false;
  for (int i = 1; i <= 30; ++i) {
    const double height_m = 0.004 - 0.0003 * i;
    world.move(plate, {{1, 0, 0, 0}, {0, 0, height_m}});
    const ContactResult r = world.tick(hip);
    wasSaid = wasSaid || r.work.depenetrated;
    EXPECT_TRUE(wasSaid || r.ihip.z < height_m) << i;
  }
  EXPECT_TRUE(wasSaid);
}

}  // namespace
}  // namespace haptics::depenetration_test

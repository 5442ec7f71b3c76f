// Contact carried over the adoption of an edited scene.

#include <gtest/gtest.h>

#include "haptic_server/engine/contact/contact.h"
#include "tests/haptic_server/engine/contact/contact_rig.h"

namespace haptics::contact_reprojection_test {
namespace {

constexpr double kTouchable = 2e-7;  // m

/// Adopts `after`, whose bodies come from where `origins` says; returns what reprojectContact() said.
bool adopt(ContactRig& before, ContactRig& after, const std::vector<BodyOrigin>& origins) {
  for (Body& body : after.bodies()) body.update();
  after.state() = before.state();
  return reprojectContact(after.state(), after.bodies(), origins);
}

void press(ContactRig& world, Vec3 from, Vec3 to) {
  world.place(from);
  world.lead(from, to, 0.0007, [](const ContactResult&, Vec3) {});
  ASSERT_TRUE(world.result().touching);
}

TEST(ContactReprojection, ContactWithAnUnchangedBodyGoesOnBitForBit) {
  const auto ball = shapes::sphere(0.05, 12).build();
  const auto box = shapes::box({0.01, 0.01, 0.01}).build();
  ContactRig with;
  ContactRig without;
  ContactRig* const worlds[] = {&with, &without};
  for (ContactRig* world : worlds) {
    world->add(box, {{1, 0, 0, 0}, {0.2, 0, 0}});
    world->add(ball);
    press(*world, {0.003, 0, 0.052}, {0.004, 0.001, 0.047});
  }
  ContactRig after;  // the ball is now the first, the box moved elsewhere
  after.add(ball);
  after.add(box, {{1, 0, 0, 0}, {0.3, 0, 0}});
  EXPECT_FALSE(adopt(with, after, {{1, false}, {0, true}}));
  for (int i = 0; i < 100; ++i) {
    const Vec3 hip{0.004 + 0.0002 * i, 0.001, 0.047};
    const ContactResult expected = without.tick(hip);
    const ContactResult r = after.tick(hip);
    EXPECT_EQ(r.body, expected.touching ? 0 : -1);
    EXPECT_EQ(r.ihip, expected.ihip);
    EXPECT_EQ(r.primitive, expected.primitive);
  }
}

TEST(ContactReprojection, ContactWithSeveralUnchangedBodiesGoesOn) {
  const auto ball = shapes::sphere(0.05, 12).build();
  ContactRig before;
  ContactRig after;
  before.add(ball, {{1, 0, 0, 0}, {0, -0.03, 0}});
  before.add(ball, {{1, 0, 0, 0}, {0, 0.03, 0}});
  after.add(ball, {{1, 0, 0, 0}, {0, 0.03, 0}});
  after.add(ball, {{1, 0, 0, 0}, {0, -0.03, 0}});
  press(before, {0, 0.001, 0.06}, {0, 0.001, 0.03});
  ASSERT_EQ(before.state().mode, ContactState::Mode::kSeveralSurfaces);
  EXPECT_FALSE(adopt(before, after, {{1, false}, {0, false}}));
  EXPECT_EQ(after.tick({0, 0.001, 0.03}).ihip, before.tick({0, 0.001, 0.03}).ihip);
}

TEST(ContactReprojection, RemovedBodyReleasesTheContact) {
  ContactRig before;
  before.add(shapes::sphere(0.05, 12));
  press(before, {0, 0, 0.052}, {0, 0, 0.045});
  ContactRig after;
  EXPECT_TRUE(adopt(before, after, {}));
  EXPECT_FALSE(after.tick({0, 0, 0.045}).touching);
  EXPECT_EQ(after.result().ihip, Vec3(0, 0, 0.045));
}

TEST(ContactReprojection, BodyMovedAwayReleasesTheContact) {
  const auto ball = shapes::sphere(0.05, 12).build();
  ContactRig before;
  before.add(ball);
  press(before, {0, 0, 0.052}, {0, 0, 0.045});
  ContactRig after;
  after.add(ball, {{1, 0, 0, 0}, {0, 0, -0.03}});
  EXPECT_TRUE(adopt(before, after, {{0, true}}));
  EXPECT_FALSE(after.tick({0, 0, 0.045}).touching);
}

TEST(ContactReprojection, BodyBehindARemovedOneHolds) {
  ContactRig before;
  before.add(shapes::box({0.1, 0.1, 0.01}, 3), Vec3(0, 0, 0.005));
  before.add(shapes::box({0.1, 0.1, 0.01}, 3), Vec3(0, 0, -0.006));
  press(before, {0.003, 0.004, 0.011}, {0.003, 0.004, -0.003});
  ContactRig after;
  after.add(shapes::box({0.1, 0.1, 0.01}, 3), Vec3(0, 0, -0.006));
  EXPECT_TRUE(adopt(before, after, {{1, false}}));
  const ContactResult r = after.tick({0.003, 0.004, -0.003});
  EXPECT_TRUE(r.touching);
  EXPECT_NEAR(r.ihip.z, -0.001, kTouchable);
}

TEST(ContactReprojection, ProxyLeavesABodyMovedOntoTheHip) {
  const auto ball = shapes::sphere(0.05, 12).build();
  for (const Vec3 to : {Vec3(0, 0, -0.045), Vec3(0.01, 0.02, -0.03), Vec3(0, 0, -0.001)}) {
    ContactRig before;
    before.add(ball, {{1, 0, 0, 0}, {0, 0, -0.2}});
    before.place({0, 0, 0});
    before.tick({0, 0, 0});
    ContactRig after;
    after.add(ball, {{1, 0, 0, 0}, to});
    EXPECT_TRUE(adopt(before, after, {{0, true}}));
    const ContactResult r = after.tick({0, 0, 0});
    EXPECT_TRUE(r.touching);
    EXPECT_LT(after.depthInside(r.ihip), kTouchable);
    EXPECT_NEAR(glm::distance(r.ihip, to), 0.05, 0.0005);
  }
}

TEST(ContactReprojection, ProxyLeavesABodyAddedOverAContact) {
  const auto floor = shapes::box({0.2, 0.2, 0.1}, 3).build();
  ContactRig before;
  before.add(floor, {{1, 0, 0, 0}, {0, 0, -0.05}});
  press(before, {0.001, 0.002, 0.003}, {0.001, 0.002, -0.002});
  ContactRig after;
  after.add(floor, {{1, 0, 0, 0}, {0, 0, -0.05}});
  after.add(shapes::box({0.04, 0.04, 0.04}, 3), Vec3(0, 0, 0.01));
  EXPECT_TRUE(adopt(before, after, {{0, false}, {-1, true}}));
  for (int i = 0; i < 20; ++i) {
    const ContactResult r = after.tick({0.001, 0.002, -0.002});
    EXPECT_TRUE(r.touching);
    EXPECT_LT(after.depthInside(r.ihip), kTouchable);
  }
}

TEST(ContactReprojection, ProxyLeavesAHeapOfOverlappingBodies) {
  for (int heap = 0; heap < 30; ++heap) {
    ContactRig before;
    before.place({0.001, 0.002, 0.003});
    before.tick({0.001, 0.002, 0.003});
    ContactRig after;
    std::vector<BodyOrigin> origins;
    for (int i = 0; i < 12; ++i) {
      const double k = heap + i;
      after.add(shapes::sphere(0.02 + 0.01 * std::sin(k), 6),
                0.03 * Vec3(std::sin(k * 1.3), std::cos(k * 2.1), std::sin(k * 0.7 + 1)));
      origins.push_back({-1, true});
    }
    if (after.depthInside({0.001, 0.002, 0.003}) == 0) continue;
    EXPECT_TRUE(adopt(before, after, origins));
    EXPECT_EQ(after.depthInside(after.state().ihip), 0) << heap;
    for (int i = 0; i < 5; ++i) {
      const ContactResult r = after.tick({0.001, 0.002, 0.003});
      EXPECT_TRUE(r.touching) << heap;
      EXPECT_LT(after.depthInside(r.ihip), kTouchable) << heap;
    }
  }
}

TEST(ContactReprojection, ProxyLeavesBodiesThatPushItIntoEachOther) {
  const Vec3 hip{0.0085, 0, 0};
  ContactRig before;
  before.place(hip);
  before.tick(hip);
  ContactRig after;
  std::vector<BodyOrigin> origins;
  for (int i = 12; i >= 0; --i) {
    after.add(shapes::box({0.01, 0.1, 0.1}, 3), Vec3(0.005 + 0.009 * i, 0, 0));
    origins.push_back({-1, true});
  }
  EXPECT_TRUE(adopt(before, after, origins));
  for (int i = 0; i < 5; ++i) {
    const ContactResult r = after.tick(hip);
    EXPECT_TRUE(r.touching);
    EXPECT_LT(after.depthInside(r.ihip), kTouchable);
  }
}

TEST(ContactReprojection, RemeshedBodyHolds) {
  for (const int n : {4, 9, 30}) {
    ContactRig before;
    before.add(shapes::sphere(0.05, 12));
    press(before, {0.001, 0.002, 0.052}, {0.011, 0.012, 0.044});
    const Vec3 ihip = before.result().ihip;
    ContactRig after;
    after.add(shapes::sphere(0.05, n));
    EXPECT_TRUE(adopt(before, after, {{0, true}}));
    const ContactResult r = after.tick({0.011, 0.012, 0.044});
    EXPECT_TRUE(r.touching);
    EXPECT_LT(after.depthInside(r.ihip), kTouchable);
    EXPECT_LT(glm::distance(r.ihip, ihip), 0.0025) << n;  // the coarse sphere's faceting
  }
}

// S17: the HIP is far beyond the plate that is re-meshed.
TEST(ContactReprojection, RemeshedThinPlateHoldsADeepHip) {
  for (const double thickness : {0.0005, 0.001}) {
    for (const int n : {1, 3, 20}) {
      for (const Vec3 end : {Vec3(0.0033, 0.0041, thickness / 2 - 0.005), Vec3(0, 0, thickness / 2 - 0.005)}) {
        ContactRig before;
        before.add(shapes::box({0.1, 0.1, thickness}, 8));
        press(before, {0.001, 0.002, 0.003}, end);
        ContactRig after;
        after.add(shapes::box({0.1, 0.1, thickness}, n));
        EXPECT_TRUE(adopt(before, after, {{0, true}}));
        for (int i = 0; i < 10; ++i) {
          const ContactResult r = after.tick(end);
          EXPECT_TRUE(r.touching);
          EXPECT_NEAR(glm::distance(r.ihip, Vec3(end.x, end.y, thickness / 2)), 0, kTouchable);
        }
      }
    }
  }
}

TEST(ContactReprojection, RemeshedSheetHolds) {
  // Tilted, so that the vertices' rounding puts the new sheet a little above or below the old one.
  const Quat tilt = glm::angleAxis(0.7, glm::normalize(Vec3(1, 2, 0.5)));
  const auto sheet = [&](int n) { return shapes::sheet(0.1, n).mapped([&](Vec3 v) { return tilt * v; }).build(); };
  for (int n = 1; n < 20; ++n) {
    ContactRig before;
    before.add(sheet(7));
    press(before, tilt * Vec3(0.001, 0.002, 0.003), tilt * Vec3(0.0033, 0.0041, -0.005));
    ContactRig after;
    after.add(sheet(n));
    EXPECT_TRUE(adopt(before, after, {{0, true}}));
    const ContactResult r = after.tick(tilt * Vec3(0.0033, 0.0041, -0.005));
    EXPECT_TRUE(r.touching) << n;
    EXPECT_GT(glm::dot(r.normal, tilt * Vec3(0, 0, 1)), 0.99) << n;
  }
}

TEST(ContactReprojection, ProxyLeavesAThinShellOnTheContactSide) {
  // A dome, re-meshed finer: the old contact, on a facet, now lies within the wall and nearer to its inner side.
  const auto dome = [](int n, double wall) {
    return shapes::box({2, 2, 1}, n).mapped([&](Vec3 v) {
      return glm::normalize(Vec3(v.x * 0.6, v.y * 0.6, 1)) * (0.05 - wall * (0.5 - v.z));
    });
  };
  const Vec3 direction = glm::normalize(Vec3(0.074, 0.076, 1));  // over the middle of a facet of the coarse dome
  const auto pressed = [&](double wall) {
    ContactRig world(dome(8, wall));
    press(world, direction * 0.052, direction * 0.046);
    return world;
  };
  ContactRig probe = pressed(0.001);
  const double sag = 0.05 - glm::length(probe.result().ihip);
  ASSERT_GT(sag, 5e-5);
  ContactRig before = pressed(sag * 1.5);
  ContactRig after;
  after.add(dome(40, sag * 1.5));
  ASSERT_GT(after.depthInside(before.result().ihip), 0);
  EXPECT_TRUE(adopt(before, after, {{0, true}}));
  const ContactResult r = after.tick(direction * 0.046);
  EXPECT_TRUE(r.touching);
  EXPECT_GT(glm::dot(r.normal, direction), 0.9);
  EXPECT_NEAR(glm::length(r.ihip), 0.05, 2e-5);
}

TEST(ContactReprojection, FreeContactStaysFree) {
  const auto ball = shapes::sphere(0.05, 12).build();
  ContactRig before;
  before.add(ball);
  before.place({0, 0, 0.06});
  before.tick({0, 0, 0.06});
  ContactRig after;
  after.add(ball, {{1, 0, 0, 0}, {0, 0, -0.001}});
  EXPECT_FALSE(adopt(before, after, {{0, true}}));
  EXPECT_FALSE(after.tick({0, 0, 0.06}).touching);
}

}  // namespace
}  // namespace haptics::contact_reprojection_test

// Ticks that spend their allowance: the IHIP lags, and nothing else changes.

#include <gtest/gtest.h>

#include <random>

#include "haptic_server/engine/contact/contact.h"
#include "tests/haptic_server/engine/contact/contact_rig.h"

namespace haptics::allowance_test {
namespace {

/// Follows the HIP with so many units for each tick, as the servo's step does.
class Bounded {
 public:
  Bounded(ContactRig& world, std::int64_t units) : world_(world), units_(units) {}

  ContactResult tick(Vec3 hip) {
    std::vector<Body>& bodies = world_.bodies();
    for (Body& body : bodies) body.update();
    ContactResult result;
    result.work.allowance = Allowance(units_);
    followContact(bodies, world_.state(), hip, result, world_.cache());
    const double reached = world_.state().reached;
    for (Body& body : bodies) {
      body.previous = reached < 1 ? interpolate(body.previous, body.current, reached) : body.current;
    }
    behind_ += result.work.allowanceSpent ? 1 : 0;
    return result;
  }
  [[nodiscard]] int behind() const { return behind_; }

 private:
  ContactRig& world_;
  std::int64_t units_;
  int behind_ = 0;
};

/// Long triangles, and one that parts the room: nothing leads round it.
shapes::Shape soupBehindAWall(int triangles) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> within(-0.05, 0.05);
  shapes::Shape soup;
  const auto add = [&](Vec3 a, Vec3 b, Vec3 c) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (const Vec3 v : {a, b, c}) soup.vertices.emplace_back(v);
    soup.triangles.push_back({first, first + 1, first + 2});
  };
  const auto somewhere = [&] { return Vec3(within(random), within(random), within(random)); };
  for (int i = 0; i < triangles; ++i) add(somewhere(), somewhere(), somewhere());
  add({-2, -2, 0}, {2, -2, 0}, {0, 3, 0});
  return soup;
}

TEST(Allowance, IsUnspentInEmptySpace) {
  ContactRig world(shapes::sphere(0.05, 20));
  world.place({0, 0, 0.3});
  Bounded bounded(world, 4000);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 hip(0.1 * std::cos(0.01 * i), 0.1 * std::sin(0.01 * i), 0.1);
    EXPECT_EQ(bounded.tick(hip).ihip, hip);
  }
  EXPECT_EQ(bounded.behind(), 0);
}

TEST(Allowance, SpentBeforeTheContainmentCheckDefersItToTheNextTick) {
  ContactRig world(shapes::sphere(0.05, 20));
  world.place({0, 0, 0.06});
  world.tick({0, 0, 0.049});
  ASSERT_EQ(world.state().mode, ContactState::Mode::kOneSurface);
  world.add(shapes::sphere(0.03, 20), Vec3(0, 0, 0.05));  // an adoption puts bodies anywhere
  world.state().containmentUnchecked = world.state().unfinished = true;
  ASSERT_GT(world.depthInside(world.state().ihip), 0.02);
  world.tick({0, 0, 0.049});
  EXPECT_FALSE(world.state().containmentUnchecked);
  EXPECT_LT(world.depthInside(world.state().ihip), 1e-6);
}

TEST(Allowance, SpentKeepsTheIhipOnTheContactSide) {
  for (const std::int64_t units : {3'000, 10'000, 30'000, 100'000}) {
    ContactRig world(soupBehindAWall(400));
    world.place({0.01, 0.02, 0.09});
    Bounded bounded(world, units);
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> within(-0.05, 0.05);
    Vec3 hip(0.01, 0.02, 0.09);
    for (int target = 0; target < 60; ++target) {
      const Vec3 to(within(random), within(random), within(random));
      const Vec3 from = hip;
      for (int i = 1; i <= 30; ++i) {
        hip = glm::mix(from, to, i / 30.0);
        const ContactResult result = bounded.tick(hip);
        ASSERT_GT(result.ihip.z, -1e-6) << units << " units, " << hip.z;
        ASSERT_GE(result.work.allowance.left(), -40'000) << "what a step takes once it is over";
        ASSERT_GE(result.penetration_m, 0);
        if (result.touching && !result.alongNormal) {
          ASSERT_NEAR(result.penetration_m, glm::distance(result.ihip, hip), 1e-12)
              << "of the HIP, not of a point before";
        }
      }
    }
    if (units < 30'000) {
      EXPECT_GT(bounded.behind(), 100) << units;
    }
  }
}

TEST(Allowance, SpentIsFollowedAlikeWithTheCacheAndWithoutIt) {
  ContactRig kept(shapes::bumpy(0.05, 40)), dropped(shapes::bumpy(0.05, 40));
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> within(-0.05, 0.05);
  Vec3 hip(0, 0, 0.08);
  kept.place(hip);
  dropped.place(hip);
  int behind = 0, touching = 0;
  for (int target = 0; target < 400; ++target) {
    const Vec3 from = hip, to(within(random), within(random), within(random));
    const int steps = target % 2 == 0 ? 40 : 4;
    for (int i = 1; i <= steps; ++i) {
      hip = glm::mix(from, to, static_cast<double>(i) / steps);
      const std::int64_t units = random() % 3 == 0 ? 40 << random() % 8 : 1'000'000;
      Bounded cached(kept, units);
      const ContactResult result = cached.tick(hip);
      dropped.cache() = {};
      const ContactResult expected = Bounded(dropped, units).tick(hip);
      ASSERT_EQ(result.ihip, expected.ihip) << target << ' ' << i;
      ASSERT_EQ(result.penetration_m, expected.penetration_m);
      behind += cached.behind();
      touching += result.touching ? 1 : 0;
    }
  }
  EXPECT_GT(behind, 100);
  EXPECT_GT(touching, 1000);
}

TEST(Allowance, SpentDefersTheRestOfThePathToTheNextTicks) {
  for (const std::int64_t units : {100'000, 200'000}) {  // some ten queries, or twenty
    ContactRig world(soupBehindAWall(2'000));
    const Vec3 from(-0.06, 0.001, 0.002), to(0.06, 0.002, 0.003);
    world.place(from);
    Bounded bounded(world, units);
    EXPECT_NE(bounded.tick(to).ihip, to);
    int ticks = 0;
    for (; ticks < 20'000 && bounded.tick(to).work.allowanceSpent; ++ticks) {
    }
    EXPECT_LT(ticks, 20'000) << units;
    EXPECT_GT(bounded.tick(to).ihip.x, from.x + 0.01) << "held somewhere on the way";
  }
}

TEST(Allowance, SpentDefersBodyMotionToo) {
  for (const std::int64_t units : {1'000, 4'000, 16'000}) {
    ContactRig world;
    for (int i = 0; i < 6; ++i) world.add(shapes::bumpy(0.02, 12), Vec3(0.015 * i, 0, 0.08));
    const Vec3 hip(0.03, 0.001, 0);
    world.place(hip);
    Bounded bounded(world, units);
    for (int i = 0; i < 400; ++i) {
      for (int b = 0; b < 6; ++b) {
        world.move(b, {{1, 0, 0, 0}, {0.015 * b, 0, 0.08 - 0.0002 * i}});
      }
      const Vec3 ihip = bounded.tick(hip).ihip;
      double depth = 0;
      for (const Body& body : world.bodies()) {
        const Vec3 local = toLocal(body.previous, ihip);  // as far as it was followed
        int spent = 0;
        const ClosestPoint foot = body.surface->closestFoot(local, 10'000, spent);
        if (!body.surface->isOutside(foot, local)) depth = std::max(depth, std::sqrt(foot.squaredDistance));
      }
      ASSERT_LT(depth, 1e-6) << units << " units, tick " << i;
    }
    if (units == 1'000) {
      EXPECT_GT(bounded.behind(), 0);
    }
  }
}

TEST(Allowance, SpentLetsASingleTurningBodyCarryTheIhip) {
  for (const std::int64_t units : {20, 60, 200}) {
    ContactRig world(shapes::bumpy(0.03, 24));
    const Vec3 hip(0, 0.001, 0.02);
    world.place({0, 0.001, 0.05});
    world.tick(hip);
    ASSERT_NE(world.state().mode, ContactState::Mode::kFree);
    Bounded bounded(world, units);
    for (int i = 0; i < 200; ++i) {
      world.move(0, {glm::angleAxis(0.05 * i, glm::normalize(Vec3(1, 0.5, 0))), Vec3(1e-4 * i, 0, 0)});
      ASSERT_LT(world.depthInside(bounded.tick(hip).ihip), 1e-6) << units << " units, tick " << i;
    }
    EXPECT_GT(bounded.behind(), 0) << units;
  }
}

TEST(Allowance, SpentDuringDepenetrationLeavesAConsistentState) {
  for (std::int64_t units = 500; units < 200'000; units *= 2) {
    ContactRig world;
    for (int i = 0; i < 6; ++i) world.add(shapes::box(Vec3(0.04), 4));
    world.place(Vec3(0));
    Bounded bounded(world, units);
    const auto closeIn = [&](double gap_m) {
      for (int i = 0; i < 6; ++i) {
        Vec3 at(0.0001);
        at[i / 2] = (i % 2 == 0 ? 1 : -1) * (0.02 + gap_m);
        world.move(i, {{1, 0, 0, 0}, at});
      }
    };
    closeIn(0.01);
    for (Body& body : world.bodies()) body.previous = body.current;
    for (int i = 0; i < 200; ++i) {
      closeIn(0.01 - 0.0001 * i);
      const ContactResult result = bounded.tick(Vec3(0));
      ASSERT_TRUE(isFinite(result.ihip)) << units;
      for (const ContactSurface& held : world.state().surfaces()) ASSERT_GE(held.body, 0) << units;
    }
  }
}

TEST(Clearance, SavesQueriesOfAFreeHipAndChangesNoBit) {
  ContactRig world;
  world.add(shapes::sphere(0.05, 40));
  world.add(shapes::box(Vec3(0.02)), Vec3(0.1, 0, 0));
  ContactRig asked;
  asked.add(shapes::sphere(0.05, 40));
  asked.add(shapes::box(Vec3(0.02)), Vec3(0.1, 0, 0));
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> within(-0.12, 0.12);
  Vec3 hip(0, 0, 0.1);
  world.place(hip);
  asked.place(hip);
  int queries = 0, ticks = 0, touching = 0;
  for (int target = 0; target < 300; ++target) {
    const Vec3 from = hip, to(within(random), within(random), within(random));
    const int steps = 1 + static_cast<int>(glm::distance(from, to) / 0.0003);
    for (int i = 1; i <= steps; ++i, ++ticks) {
      hip = glm::mix(from, to, static_cast<double>(i) / steps);
      if (target % 3 == 1) {
        const double turn = 0.01 * i;
        for (ContactRig* each : {&world, &asked}) {
          each->move(1, {{std::cos(turn), 0, std::sin(turn), 0}, {0.1 + 0.01 * std::sin(turn), 0, 0}});
        }
      }
      const ContactResult result = world.tick(hip);
      asked.state().clear = {};
      const ContactResult expected = asked.tick(hip);
      ASSERT_EQ(result.touching, expected.touching) << ticks;
      ASSERT_EQ(result.ihip, expected.ihip) << ticks;
      queries += !result.touching && result.work.segments > 0 ? 1 : 0;
      touching += result.touching ? 1 : 0;
    }
  }
  EXPECT_GT(touching, ticks / 100);
  EXPECT_LT(queries, (ticks - touching) / 3);
}

}  // namespace
}  // namespace haptics::allowance_test

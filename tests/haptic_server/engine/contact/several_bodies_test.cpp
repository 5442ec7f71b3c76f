// Bodies that touch, overlap and move: the IHIP penetrates none of them. S2 of the failure scenes.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/near_bodies.h"
#include "tests/haptic_server/engine/contact/contact_rig.h"

namespace haptics::several_bodies_test {
namespace {

constexpr double kTouchable = 6e-7;  // m: twice the skin of the scenes below, and the vertices' rounding

TEST(SeveralBodies, SlidingContactStopsAtASecondBody) {  // S2
  for (const double sunk : {0.0, 0.001, 0.01}) {
    ContactRig world;
    world.add(shapes::box({0.3, 0.3, 0.1}, 4), Vec3(0, 0, -0.05));
    world.add(shapes::box({0.04, 0.04, 0.04}, 2), Vec3(0.04, 0, 0.02 - sunk));
    world.place({-0.02, 0.003, 0.001});
    world.tick({-0.02, 0.003, -0.003});
    world.lead({-0.02, 0.003, -0.003}, {0.05, 0.003, -0.003}, 0.001, [&](const ContactResult& r, Vec3 hip) {
      ASSERT_TRUE(r.touching);
      EXPECT_LT(world.depthInside(r.ihip), kTouchable);
      EXPECT_NEAR(r.ihip.x, std::min(hip.x, 0.02), kTouchable);  // the box's side: a lateral force
      EXPECT_NEAR(r.ihip.z, 0, kTouchable);
    });
    // Back out of the corner, up the box's side and away: each surface is released in its turn.
    world.lead({0.05, 0.003, -0.003}, {0.03, 0.003, 0.01}, 0.001, [&](const ContactResult& r, Vec3 hip) {
      EXPECT_NEAR(r.ihip.x, 0.02, kTouchable);
      EXPECT_NEAR(r.ihip.z, std::max(hip.z, 0.0), kTouchable);
    });
    world.lead({0.03, 0.003, 0.01}, {0.0, 0.003, 0.01}, 0.001, [&](const ContactResult& r, Vec3 hip) {
      EXPECT_TRUE(r.touching == (hip.x > 0.02) || std::abs(hip.x - 0.02) < kTouchable);
    });
  }
}

/// A HIP d below flush boxes: the IHIP is above it, wherever it presses or goes.
void expectOneSurface(ContactRig& world, double width, double d) {
  const auto isAbove = [&](const ContactResult& r, Vec3 hip) {
    if (hip.z > -1e-5) return;
    ASSERT_TRUE(r.touching) << hip.x << ' ' << hip.y;
    EXPECT_NEAR(r.ihip.x, hip.x, kTouchable);
    EXPECT_NEAR(r.ihip.y, hip.y, kTouchable);
    EXPECT_NEAR(r.ihip.z, 0, kTouchable);
  };
  const double seam = width / 2;
  for (const double x : {0.0, seam, seam + 1e-9, -seam, 1.3 * seam}) {
    world.place({x, 0.01, 0.005});
    world.lead({x, 0.01, 0.005}, {x, 0.01, -d}, 0.0002, isAbove);
    world.lead({x, 0.01, -d}, {x, -0.02, -d}, 0.0003, isAbove);
    world.lead({x, -0.02, -d}, {1.8 * seam, 0.013, -d}, 0.0003, isAbove);
    world.lead({1.8 * seam, 0.013, -d}, {-1.8 * seam, -0.017, -d}, 0.0003, isAbove);
    world.lead({-1.8 * seam, -0.017, -d}, {seam, 0, -d}, 0.0003, isAbove);
  }
}

TEST(SeveralBodies, FlushByTheirDecimalSizesAreOneSurface) {
  for (const double width : {0.02, 0.0232, 0.015, 0.0303}) {
    ContactRig world;
    for (int i = -1; i <= 1; ++i) world.add(shapes::box({width, 0.1, 0.01}, 1), Vec3(i * width, 0, -0.005));
    expectOneSurface(world, width, 0.00126);
    expectOneSurface(world, width, 0.004);
  }
}

/// Six boxes, each meshed in a frame of its own, so that their tops are level and their walls flush but for rounding, under a
/// floor that is turned anyhow; the HIP goes along a seam, and over where four meet.
TEST(SeveralBodies, FlushButForRoundingIsOneSurfaceAndIsFollowedInFewSteps) {
  const Vec3 size(0.232, 0.31, 0.1);
  for (int seed = 0; seed < 60; ++seed) {
    const auto some = [&](int k) { return std::sin(1.0 + 12.9898 * seed + 78.233 * k); };
    const auto turn = [&](int k) {
      return glm::angleAxis(3 * some(k), glm::normalize(Vec3(some(k + 1), some(k + 2), 0.3)));
    };
    const Pose floor{turn(0), Vec3(some(3), some(4), some(5))};
    ContactRig world;
    for (int i = 0; i < 6; ++i) {
      const Quat own = turn(10 * i), back = glm::conjugate(own);
      const Vec3 middle((i % 3 - 1) * size.x, (i / 3 - 0.5) * size.y, -size.z / 2);
      world.add(shapes::box(size, 2).mapped([&](Vec3 v) { return back * v; }),
                Pose{floor.rotation * own, toWorld(floor, middle)});
    }
    const auto goes = [&](Vec3 from, Vec3 to) {
      constexpr int kTicks = 60;
      for (int i = 0; i <= kTicks; ++i) {
        const Vec3 hip = glm::mix(from, to, double(i) / kTicks);
        const ContactResult r = world.tick(toWorld(floor, hip));
        const Vec3 off = toLocal(floor, r.ihip) - hip;
        EXPECT_LT(std::hypot(off.x, off.y), 1e-6) << seed << ' ' << hip.x << ' ' << hip.y;
        EXPECT_LE(r.work.steps, 20) << seed << ' ' << hip.x << ' ' << hip.y;
      }
    };
    const double seam = size.x / 2, deep = -0.02;
    world.place(toWorld(floor, {seam, -0.2, 0.01}));
    goes({seam, -0.2, 0.01}, {seam, -0.2, deep});
    goes({seam, -0.2, deep}, {seam, 0.2, deep});
    goes({seam, 0.2, deep}, {-seam, -0.1, deep});
    goes({-seam, -0.1, deep}, {0.2, 0, deep});
    goes({0.2, 0, deep}, {-0.2, 0, deep});
  }
}

TEST(SeveralBodies, PartsOfOneMeshWithAGapBelowTheSkinAreOneSurface) {
  for (const double gap : {1e-9, 3e-8, 9e-8}) {
    shapes::Shape all;
    for (int i = -1; i <= 1; ++i) all.add(shapes::box({0.02, 0.1, 0.01}, 1), Vec3(i * (0.02 + gap), 0, -0.005));
    ContactRig world(all);
    expectOneSurface(world, 0.02, 0.00126);
  }
}

TEST(SeveralBodies, WallBesideAWideGapIsGoneDown) {
  ContactRig world;
  for (const double x : {-0.0101, 0.0101}) world.add(shapes::box({0.02, 0.1, 0.01}, 1), Vec3(x, 0, -0.005));
  world.place({0, 0, 0.005});
  world.lead({0, 0, 0.005}, {0, 0, -0.004}, 0.0002, [](const ContactResult& r, Vec3) { EXPECT_FALSE(r.touching); });
  world.lead({0, 0, -0.004}, {0.002, 0, -0.004}, 0.0002, [](const ContactResult&, Vec3) {});
  EXPECT_NEAR(world.result().ihip.x, 1e-4, kTouchable);
  EXPECT_NEAR(world.result().ihip.z, -0.004, kTouchable);
}

TEST(SeveralBodies, ThreeBodiesHoldAPoint) {
  ContactRig world;
  world.add(shapes::box({0.2, 0.2, 0.1}, 3), Vec3(0.1, 0.1, -0.05));
  world.add(shapes::box({0.1, 0.2, 0.2}, 3), Vec3(-0.05, 0.1, 0.05));
  world.add(shapes::box({0.2, 0.1, 0.2}, 3), Vec3(0.05, -0.05, 0.05));
  world.place({0.01, 0.012, 0.014});
  world.lead({0.01, 0.012, 0.014}, {-0.003, -0.001, -0.002}, 0.0007, [](const ContactResult&, Vec3) {});
  const ContactResult r = world.result();
  EXPECT_TRUE(r.touching);
  EXPECT_NEAR(glm::distance(r.ihip, Vec3(0)), 0, kTouchable);
  EXPECT_EQ(r.body, 1);  // pushed out of the deepest above all
  EXPECT_NEAR(glm::dot(r.normal, glm::normalize(Vec3(3, 1, 2))), 1, 1e-4);
}

TEST(SeveralBodies, IhipSlidesAlongASeam) {
  ContactRig world;
  world.add(shapes::sphere(0.05, 16), Vec3(0, -0.03, 0));
  world.add(shapes::sphere(0.05, 16), Vec3(0, 0.03, 0));
  world.place({0, 0.001, 0.06});
  world.lead({0, 0.001, 0.06}, {0, 0.001, 0.03}, 0.001, [](const ContactResult&, Vec3) {});
  int line = 0;
  for (int i = 0; i < 200; ++i) {
    const double angle = 0.002 * i;
    const ContactResult r = world.tick(Vec3(std::sin(angle), 0.02, std::cos(angle)) * 0.03);
    ASSERT_TRUE(r.touching);
    EXPECT_LT(world.depthInside(r.ihip), kTouchable);
    // The seam is the circle of radius 40 mm in the plane y = 0; the meshes are inscribed in their spheres.
    EXPECT_NEAR(r.ihip.y, 0, 0.0005);
    EXPECT_NEAR(glm::length(r.ihip), 0.04, 0.0008);
    line += world.state().mode == ContactState::Mode::kSeveralSurfaces ? 1 : 0;
  }
  EXPECT_GT(line, 150);
}

TEST(SeveralBodies, ActiveSetFollowsASeamTriangleByTriangle) {
  ContactRig world;
  world.add(shapes::sphere(0.05, 40), Pose{glm::angleAxis(0.3, Vec3(0, 0.6, 0.8)), {0.036, 0, 0}});
  world.add(shapes::sphere(0.05, 40), Pose{glm::angleAxis(1.0, Vec3(0.6, 0, 0.8)), {-0.036, 0, 0}});
  const auto hipAt = [](double angle) { return Vec3(0, std::cos(angle), std::sin(angle)) * 0.031; };
  world.place({0, 0.06, 0});
  world.lead({0, 0.06, 0}, hipAt(0), 0.0005, [](const ContactResult&, Vec3) {});
  int metAnew = 0;
  for (int i = 1; i <= 2000; ++i) {
    const ContactResult r = world.tick(hipAt(0.003 * i));
    ASSERT_EQ(world.state().mode, ContactState::Mode::kSeveralSurfaces);
    EXPECT_EQ(world.depthInside(r.ihip), 0) << i;
    EXPECT_NEAR(r.penetration_m, 0.0037, 0.0003) << i;
    metAnew += r.work.solverRounds > 0 ? 1 : 0;
  }
  EXPECT_LT(metAnew, 20);
}

/// At a saddle's vertex the planes of three triangles hold a point, the surface need not.
TEST(SeveralBodies, TrianglesAroundAVertexAreOneSurface) {
  ContactRig world;
  world.add(shapes::bumpy(0.05, 12));
  world.add(shapes::box({0.1, 0.1, 0.02}, 4), Pose{glm::angleAxis(0.7, Vec3(0.6, 0, 0.8)), {0, 0, 0.045}});
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  Vec3 hip{0, 0.1, 0};
  world.place(hip);
  const auto meet = [](const TriangleRecord& a, const TriangleRecord& b) {
    return b.cornerOf(a.vertexAt(0)) >= 0 || b.cornerOf(a.vertexAt(1)) >= 0 || b.cornerOf(a.vertexAt(2)) >= 0;
  };
  int several = 0;
  for (int stroke = 0; stroke < 200; ++stroke) {
    const Vec3 aim = 0.025 * Vec3(normal(random), normal(random), 0.5 + normal(random));
    world.lead(hip, aim, 0.0005, [&](const ContactResult& r, Vec3) {
      if (world.state().mode != ContactState::Mode::kSeveralSurfaces || r.work.notConverged) return;
      ++several;
      const auto held = world.state().surfaces();
      const CollisionMesh& mesh = *world.bodies()[static_cast<std::size_t>(held.front().body)].surface;
      const bool oneFan = std::all_of(held.begin(), held.end(), [&](const ContactSurface& s) {
        return s.body == held.front().body && meet(mesh.triangle(s.triangle), mesh.triangle(held.front().triangle));
      });
      EXPECT_FALSE(oneFan && held.size() > 1);
    });
    hip = aim;
  }
  EXPECT_GT(several, 100);
}

/// Each tick divided by 64 is the path of a slow hand.
TEST(SeveralBodies, EndsWhereSmallTicksEnd) {
  ContactRig world;
  world.add(shapes::sphere(0.05, 40), Pose{glm::angleAxis(0.3, Vec3(0, 0.6, 0.8)), {0.036, 0, 0}});
  world.add(shapes::bumpy(0.05, 40), Pose{glm::angleAxis(1.0, Vec3(0.6, 0, 0.8)), {-0.036, 0, 0}});
  Vec3 hip{0, 0.06, 0};
  world.place(hip);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  int compared = 0;
  int elsewhere = 0;
  for (int stroke = 0; stroke < 25; ++stroke) {
    const Vec3 aim(0.002 * normal(random), 0.03 + 0.01 * normal(random), 0.02 * normal(random));
    world.lead(hip, aim, 0.0003, [&](const ContactResult&, Vec3 at) {
      ContactState slow = world.state();
      const Vec3 next = at + glm::normalize(aim - hip) * 0.0003;
      ContactState quick = slow;
      Vec3 reference(0);
      for (int i = 1; i <= 64; ++i)
        reference = followContact(world.bodies(), slow, glm::mix(at, next, i / 64.0), world.cache()).ihip;
      if (slow.mode != ContactState::Mode::kSeveralSurfaces) return;
      ++compared;
      elsewhere +=
          glm::distance(followContact(world.bodies(), quick, next, world.cache()).ihip, reference) > 1e-5 ? 1 : 0;
    });
    hip = aim;
  }
  EXPECT_GT(compared, 500);
  EXPECT_LT(elsewhere, compared / 200);
}

TEST(SeveralBodies, ClosingBodiesDoNotSwallowTheIhip) {
  // A press closes on a still HIP; then it opens again.
  ContactRig world;
  const int below = world.add(shapes::box({0.1, 0.1, 0.02}, 3), Vec3(0, 0, -0.02));
  const int above = world.add(shapes::sphere(0.03, 10), Vec3(0, 0, 0.04));
  const Vec3 hip{0.001, 0.0005, -0.002};
  world.place({0.001, 0.0005, 0.002});
  for (int i = 0; i < 120; ++i) {
    const double closing = 0.0002 * (i < 60 ? i : 120 - i);
    world.move(below, {{1, 0, 0, 0}, {0, 0, -0.02 + closing}});
    world.move(above, {{1, 0, 0, 0}, {0, 0, 0.04 - closing}});
    const ContactResult r = world.tick(hip);
    ASSERT_TRUE(isFinite(r.ihip));
    if (2 * closing < 0.02 - 0.0001) {
      EXPECT_LT(world.depthInside(r.ihip), kTouchable) << i;
    }
  }
}

TEST(SeveralBodies, MovingBodyPushesTheIhipAlongAnother) {
  // Pressed on a floor at rest, a wall comes along and takes the IHIP with it.
  ContactRig world;
  world.add(shapes::box({0.3, 0.3, 0.1}, 4), Vec3(0, 0, -0.05));
  const int wall = world.add(shapes::box({0.01, 0.1, 0.1}, 4), Vec3(-0.02, 0, 0.03));
  const Vec3 hip{0, 0.003, -0.002};
  world.place({0, 0.003, 0.001});
  world.tick(hip);
  for (int i = 0; i < 200; ++i) {
    const double x = -0.02 + 0.0003 * i;
    world.move(wall, {{1, 0, 0, 0}, {x, 0, 0.03}});
    const ContactResult r = world.tick(hip);
    ASSERT_TRUE(r.touching);
    EXPECT_NEAR(r.ihip.x, std::max(0.0, x + 0.005), kTouchable) << i;
    EXPECT_NEAR(r.ihip.z, 0, kTouchable);
  }
}

TEST(SeveralBodies, SelfIntersectingMeshIsGuarded) {
  shapes::Shape crossed = shapes::box({0.3, 0.3, 0.1}, 4).mapped([](Vec3 v) { return v - Vec3(0, 0, 0.05); });
  crossed.add(shapes::box({0.04, 0.04, 0.06}, 3), Vec3(0.0403, 0.0007, 0.02));
  ContactRig world;
  const int body = world.add(crossed);
  ASSERT_TRUE(world.bodies()[static_cast<std::size_t>(body)].surface->anySelfIntersecting());
  world.place({-0.02, 0.003, 0.001});
  world.tick({-0.02, 0.003, -0.003});
  world.lead({-0.02, 0.003, -0.003}, {0.05, 0.003, -0.003}, 0.001, [&](const ContactResult& r, Vec3 hip) {
    ASSERT_TRUE(r.touching);
    EXPECT_NEAR(r.ihip.x, std::min(hip.x, 0.0203), kTouchable);
    EXPECT_NEAR(r.ihip.z, 0, kTouchable);
  });
}

TEST(SeveralBodies, MeshBentIntoItselfIsGuarded) {
  // A bar along x whose end is bent up, back and down again, through its top at x = 0.15.
  constexpr double kArcBegins_m = 0.2;
  constexpr double kArcRadius_m = 0.04;
  constexpr double kArc_m = 1.5 * std::numbers::pi * kArcRadius_m;
  constexpr double kLength_m = kArcBegins_m + kArc_m + 0.08;
  const shapes::Shape straight = shapes::box({kLength_m, 0.06, 0.02}, 24);
  const shapes::Shape bent = straight.mapped([=](Vec3 v) {
    const double way = v.x + kLength_m / 2;
    const double angle = std::clamp(way - kArcBegins_m, 0.0, kArc_m) / kArcRadius_m;
    const double beyond = std::max(way - kArcBegins_m - kArc_m, 0.0);
    const double inwards = kArcRadius_m - v.z;
    return Vec3(std::min(way, kArcBegins_m) + inwards * std::sin(angle), v.y,
                kArcRadius_m - inwards * std::cos(angle) - beyond);
  });
  ContactRig world(refitCollisionMesh(*straight.build(), bent.vertices));
  world.place({0.05, 0.003, 0.011});
  world.tick({0.05, 0.003, 0.007});
  world.lead({0.05, 0.003, 0.007}, {0.2, 0.003, 0.007}, 0.001, [&](const ContactResult& r, Vec3 hip) {
    ASSERT_TRUE(r.touching);
    EXPECT_NEAR(r.ihip.x, std::min(hip.x, 0.15), kTouchable);
    EXPECT_NEAR(r.ihip.z, 0.01, kTouchable);
  });
}

TEST(SeveralBodies, BodiesBeyondMaxNearAreCountedAndTheFarthestDropped) {
  ContactRig world;
  const auto ball = shapes::sphere(0.01, 4).build();
  for (int i = 0; i < kMaxNear + 5; ++i) world.add(ball, {{1, 0, 0, 0}, {0.000001 * i, 0, 0}});
  world.place({0, 0, 0.011});
  const ContactResult r = world.tick({0, 0, 0.0099});
  EXPECT_TRUE(r.touching);
  EXPECT_EQ(r.work.droppedBodies, 5);
}

/// One moves so near that it may push the IHIP to where another one, which moves too, may push it to a third.
TEST(NearBodies, AreThoseThatBodiesBringIntoReachInAnyOrder) {
  const auto ball = shapes::sphere(0.02, 6).build();
  const auto at = [&](Vec3 before, Vec3 now) {
    Body body;
    body.surface = ball.get();
    body.previous = {{1, 0, 0, 0}, before};
    body.current = {{1, 0, 0, 0}, now};
    body.update();
    return body;
  };
  const Body first = at({0.026, 0, 0}, {0.021, 0, 0}), second = at({-0.05, 0, 0}, {-0.045, 0, 0}),
             third = at({0, 0.055, 0}, {0, 0.055, 0});
  ContactState state;
  resetContact(state, Vec3(0));
  for (const std::vector<Body>& bodies : {std::vector{first, second, third}, std::vector{second, third, first}}) {
    NearBodies near;
    ContactWork work;
    near.gather(bodies, state, Vec3(0), work);
    EXPECT_EQ(near.count(), 3);
  }
}

}  // namespace
}  // namespace haptics::several_bodies_test

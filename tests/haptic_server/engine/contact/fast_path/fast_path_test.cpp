// The fast path gives the bits of the general tick, in all that is kept and reported, whatever the cache holds.

#include "haptic_server/engine/contact/fast_path/fast_path.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <functional>
#include <random>

#include "haptic_server/engine/contact/contact_tick.h"
#include "tests/haptic_server/engine/contact/contact_rig.h"

namespace haptics::fast_path_test {
namespace {

using Bits = std::array<std::uint64_t, 3>;
Bits bits(Vec3 v) {
  return {std::bit_cast<std::uint64_t>(v.x), std::bit_cast<std::uint64_t>(v.y), std::bit_cast<std::uint64_t>(v.z)};
}

/// But for the clearance, which the general tick does not keep.
void expectSame(ContactState a, ContactState b) {
  a.clear = b.clear = {};
  ASSERT_EQ(std::memcmp(&a, &b, sizeof a), 0);
}

void expectSame(const ContactResult& a, const ContactResult& b) {
  ASSERT_EQ(a.touching, b.touching);
  ASSERT_EQ(a.body, b.body);
  ASSERT_EQ(bits(a.ihip), bits(b.ihip));
  ASSERT_EQ(bits(a.normal), bits(b.normal));
  ASSERT_EQ(std::bit_cast<std::uint64_t>(a.penetration_m), std::bit_cast<std::uint64_t>(b.penetration_m));
  ASSERT_EQ(a.alongNormal, b.alongNormal);
  ASSERT_EQ(a.primitive, b.primitive);
  ASSERT_EQ(a.triangle, b.triangle);
  ASSERT_EQ(a.work.triangles, b.work.triangles);
  ASSERT_EQ(a.work.segments, b.work.segments);
  ASSERT_EQ(a.work.steps, b.work.steps);
  ASSERT_EQ(a.work.solverRounds, b.work.solverRounds);
  ASSERT_EQ(a.work.droppedBodies, b.work.droppedBodies);
  ASSERT_EQ(a.work.interrupted, b.work.interrupted);
  ASSERT_EQ(a.work.notConverged, b.work.notConverged);
}

const Pose kAslant{glm::angleAxis(0.7, glm::normalize(Vec3(1, 2, 3))), {0.003, -0.002, 0.001}};
const Pose kFar{glm::angleAxis(1.1, glm::normalize(Vec3(2, -1, 1))), {0.3, 0.1, 0}};

constexpr int kNever = -1;

struct Scene {
  const char* name;
  int minFastPercent;  ///< Of the ticks in contact, those that the fast path computes.
  std::function<void(ContactRig&)> fill;
  std::function<void(ContactRig&, int tick)> animate = [](ContactRig&, int) {};
  friend std::ostream& operator<<(std::ostream& out, const Scene& scene) { return out << scene.name; }
};

std::vector<Scene> scenes() {
  return {
      {"Sphere", 50, [](ContactRig& w) { w.add(shapes::sphere(0.04, 12), kAslant); }},
      {"FineSphere", 30, [](ContactRig& w) { w.add(shapes::sphere(0.04, 60), kAslant); }},
      {"Torus", 50, [](ContactRig& w) { w.add(shapes::torus(0.035, 0.012, 40, 20), kAslant); }},
      {"Box", 50,
       [](ContactRig& w) {
         w.add(shapes::box({0.07, 0.06, 0.05}, 3), kAslant);
       }},
      {"Bumpy", 30, [](ContactRig& w) { w.add(shapes::bumpy(0.04, 12), kAslant); }},
      {"Sheet", 10, [](ContactRig& w) { w.add(shapes::sheet(0.08, 8), kAslant); }},
      {"SecondBodyFarAway", 30,
       [](ContactRig& w) {
         w.add(shapes::sphere(0.02, 8), kFar);
         w.add(shapes::sphere(0.04, 12), kAslant);
       }},
      {"OverlappingBodies", 1,
       [](ContactRig& w) {
         w.add(shapes::sphere(0.03, 10), {{1, 0, 0, 0}, {0.02, 0, 0}});
         w.add(shapes::bumpy(0.03, 10), {{1, 0, 0, 0}, {-0.02, 0.01, 0}});
       }},
      {"BodiesWithGap", 30,
       [](ContactRig& w) {
         w.add(shapes::sphere(0.03, 10), {kAslant.rotation, {0.0302, 0, 0}});
         w.add(shapes::sphere(0.03, 20), {kFar.rotation, {-0.0302, 0, 0}});
       }},
      {"FlushTiles", 30,
       [](ContactRig& w) {
         w.add(shapes::box({0.06, 0.06, 0.06}, 3), {kAslant.rotation, kAslant.rotation * Vec3(-0.02, 0, 0)});
         w.add(shapes::box({0.06, 0.06, 0.06}, 2), {kAslant.rotation, kAslant.rotation * Vec3(0.02, 0, 0)});
       }},
      {"MoreBodiesThanMaxNear", 0,
       [](ContactRig& w) {
         w.add(shapes::sphere(0.04, 12));
         for (int i = 0; i < 2 * kMaxNear; ++i)
           w.add(shapes::sphere(0.006, 2), Vec3(0, 0.002 * (i % 32) - 0.03, 0.045));
       }},
      {"BodyPendingRemoval", 30,
       [](ContactRig& w) {
         w.add(shapes::sphere(0.04, 12));
         w.add(shapes::box({0.02, 0.02, 0.1}), kAslant);
         w.bodies()[1].pendingRemoval = true;
       }},
      {"SelfIntersectingMesh", kNever,
       [](ContactRig& w) {
         shapes::Shape s = shapes::bumpy(0.03, 8);
         s.add(shapes::box({0.02, 0.02, 0.08}, 4), Vec3(0.01, 0.004, 0));
         w.add(s);
       }},
      {"TurningBody", kNever, [](ContactRig& w) { w.add(shapes::bumpy(0.04, 12)); },
       [](ContactRig& w, int i) {
         w.move(0, {glm::angleAxis(0.001 * i, glm::normalize(Vec3(1, 2, 3))), Vec3(0)});
       }},
      {"TurningBodyFarAway", kNever,
       [](ContactRig& w) {
         w.add(shapes::sphere(0.04, 12));
         w.add(shapes::bumpy(0.02, 8), kFar);
       },
       [](ContactRig& w, int i) {
         w.move(1, {glm::angleAxis(0.001 * i, glm::normalize(Vec3(1, 2, 3))), kFar.position});
       }},
  };
}

class FastPath : public testing::TestWithParam<Scene> {
 protected:
  static constexpr int kTicks = 12'000;

  FastPath() {
    GetParam().fill(world_);
    world_.place(hip_);
  }
  /// Where the HIP is at tick i of a random walk over the surface.
  Vec3 nextHip(int i) {
    const double pace = std::array{0.0001, 0.00001, 0.0004}[static_cast<std::size_t>(i / 500) % 3];
    step_ = step_ * 0.9 + Vec3(push_(random_), push_(random_), push_(random_)) * pace * 0.4;
    if (glm::length(hip_) > 0.036) step_ -= hip_ * (pace * 3);
    hip_ += step_;
    GetParam().animate(world_, i);
    return hip_;
  }

  ContactRig world_;

 private:
  std::mt19937_64 random_{5};
  std::normal_distribution<double> push_{0, 1};
  Vec3 hip_{0.001, 0.002, 0.09};
  Vec3 step_{0};  // m per tick
};

TEST_P(FastPath, GivesTheBitsOfTheGeneralTick) {
  int touching = 0;
  int fast = 0;
  for (int i = 0; i < kTicks; ++i) {
    const Vec3 hip = nextHip(i);
    world_.state().clear = {};  // a free general tick has queries to count
    const ContactState before = world_.state();
    ContactCache cache = world_.cache();
    std::vector<Body> bodies = world_.bodies();
    for (Body& body : bodies) body.update();
    const ContactResult result = world_.tick(hip);

    ContactState general = before;
    ContactResult expected;
    followGuarded(bodies, general, hip, expected);
    ASSERT_NO_FATAL_FAILURE(expectSame(result, expected)) << "tick " << i;
    ASSERT_NO_FATAL_FAILURE(expectSame(world_.state(), general)) << "tick " << i;
    touching += result.touching ? 1 : 0;
    ContactState state = before;
    ContactResult found;
    if (state.mode != ContactState::Mode::kOneSurface) continue;
    if (!stayOnPolygon(bodies, state, hip, found, cache) && !followUnblocked(bodies, state, hip, found, cache))
      continue;
    ASSERT_NO_FATAL_FAILURE(expectSame(state, general)) << "tick " << i;
    ++fast;
  }
  EXPECT_GT(touching, kTicks / 50);
  EXPECT_GE(fast * 100, touching * GetParam().minFastPercent);
  if (GetParam().minFastPercent == kNever) {
    EXPECT_EQ(fast, 0);
  }
}

/// Also the clearance, which is kept in the state.
TEST_P(FastPath, DroppingTheCacheAtAnyTickChangesNoBit) {
  std::mt19937_64 random(7);
  ContactState state = world_.state();
  ContactCache dropped;
  for (int i = 0; i < kTicks; ++i) {
    const Vec3 hip = nextHip(i);
    if (random() % 3 == 0) dropped = {};
    std::vector<Body> bodies = world_.bodies();
    for (Body& body : bodies) body.update();
    ContactResult result;
    followContact(bodies, state, hip, result, dropped);
    ASSERT_NO_FATAL_FAILURE(expectSame(world_.tick(hip), result)) << "tick " << i;
    ASSERT_EQ(std::memcmp(&world_.state(), &state, sizeof state), 0) << "tick " << i;
  }
}

/// Two blocks stand flush on a floor but for 10 nm between them.
TEST(FastPathGuard, LeavesAGapThatIsClosedToTheGeneralTick) {
  constexpr double kHalfGap_m = 5e-9, kWide_m = 0.02;
  for (const bool isFast : {false, true}) {
    ContactRig world;
    world.add(shapes::box({0.1, 0.1, 0.01}), Pose{{1, 0, 0, 0}, {0, 0, -0.005}});
    for (const double side : {-1.0, 1.0})
      world.add(shapes::box({kWide_m, kWide_m, kWide_m}),
                Pose{{1, 0, 0, 0}, {side * (kWide_m / 2 + kHalfGap_m), kWide_m / 2, kWide_m / 2}});
    for (int i = 0; i < 3000; ++i) {
      const Vec3 hip{0, -0.0015 + 1e-6 * i, i < 10 ? 0.001 - 3e-4 * i : -0.002};
      if (!isFast) world.cache() = {};
      ContactState state = world.state();
      std::vector<Body> bodies = world.bodies();
      for (Body& body : bodies) body.update();
      ContactResult result;
      if (isFast) {
        followContact(bodies, state, hip, result, world.cache());
      } else {
        followGuarded(bodies, state, hip, result);
      }
      world.state() = state;
      ASSERT_LT(result.ihip.y, 1e-6) << isFast << " tick " << i;
    }
    EXPECT_NEAR(world.state().ihip.z, 0, 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, FastPath, testing::ValuesIn(scenes()),
                         [](const auto& scene) { return scene.param.name; });

}  // namespace
}  // namespace haptics::fast_path_test

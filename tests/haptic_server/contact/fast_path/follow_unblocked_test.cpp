// The short way through a tick gives what the long way gives, bit for bit, in all that is kept and reported.

#include <gtest/gtest.h>

#include <bit>
#include <functional>
#include <random>

#include "haptic_server/contact/contact_tick.h"
#include "haptic_server/contact/fast_path/fast_path.h"
#include "tests/haptic_server/contact/world.h"

namespace haptics::follow_unblocked_test {
namespace {

using Bits = std::array<std::uint64_t, 3>;
Bits bits(Vec3 v) {
  return {std::bit_cast<std::uint64_t>(v.x), std::bit_cast<std::uint64_t>(v.y), std::bit_cast<std::uint64_t>(v.z)};
}

void expectSame(const ContactState& a, const ContactState& b) {
  ASSERT_EQ(a.mode, b.mode);
  ASSERT_EQ(a.holdingCount, b.holdingCount);
  ASSERT_EQ(bits(a.hip), bits(b.hip));
  ASSERT_EQ(bits(a.ihip), bits(b.ihip));
  ASSERT_EQ(bits(a.local), bits(b.local));
  for (std::size_t i = 0; i < a.holding.size(); ++i) {
    ASSERT_EQ(a.holding[i].body, b.holding[i].body);
    ASSERT_EQ(a.holding[i].side, b.holding[i].side);
    ASSERT_EQ(a.holding[i].triangle, b.holding[i].triangle);
  }
}

void expectSame(const ContactResult& a, const ContactResult& b) {
  ASSERT_EQ(a.touching, b.touching);
  ASSERT_EQ(a.body, b.body);
  ASSERT_EQ(bits(a.ihip), bits(b.ihip));
  ASSERT_EQ(bits(a.normal), bits(b.normal));
  ASSERT_EQ(std::bit_cast<std::uint64_t>(a.penetration_m), std::bit_cast<std::uint64_t>(b.penetration_m));
  ASSERT_EQ(a.primitive, b.primitive);
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
  int leastShort;  ///< Of 100 ticks in contact, those that go the short way.
  std::function<void(World&)> fill;
  std::function<void(World&, int tick)> animate = [](World&, int) {};
  friend std::ostream& operator<<(std::ostream& out, const Scene& scene) { return out << scene.name; }
};

std::vector<Scene> scenes() {
  return {
      {"Sphere", 50, [](World& w) { w.add(shapes::sphere(0.04, 12), kAslant); }},
      {"FineSphere", 30, [](World& w) { w.add(shapes::sphere(0.04, 60), kAslant); }},
      {"Torus", 50, [](World& w) { w.add(shapes::torus(0.035, 0.012, 40, 20), kAslant); }},
      {"Box", 50,
       [](World& w) {
         w.add(shapes::box({0.07, 0.06, 0.05}, 3), kAslant);
       }},
      {"Bumpy", 30, [](World& w) { w.add(shapes::bumpy(0.04, 12), kAslant); }},
      {"Sheet", 10, [](World& w) { w.add(shapes::sheet(0.08, 8), kAslant); }},
      {"OneOfTwo", 30,
       [](World& w) {
         w.add(shapes::sphere(0.02, 8), kFar);
         w.add(shapes::sphere(0.04, 12), kAslant);
       }},
      {"TwoThatOverlap", 1,
       [](World& w) {
         w.add(shapes::sphere(0.03, 10), {{1, 0, 0, 0}, {0.02, 0, 0}});
         w.add(shapes::bumpy(0.03, 10), {{1, 0, 0, 0}, {-0.02, 0.01, 0}});
       }},
      {"TwoWithAGapBetween", 30,
       [](World& w) {
         w.add(shapes::sphere(0.03, 10), {kAslant.rotation, {0.0302, 0, 0}});
         w.add(shapes::sphere(0.03, 20), {kFar.rotation, {-0.0302, 0, 0}});
       }},
      {"TilesThatAreFlush", 30,
       [](World& w) {
         w.add(shapes::box({0.06, 0.06, 0.06}, 3), {kAslant.rotation, kAslant.rotation * Vec3(-0.02, 0, 0)});
         w.add(shapes::box({0.06, 0.06, 0.06}, 2), {kAslant.rotation, kAslant.rotation * Vec3(0.02, 0, 0)});
       }},
      {"MoreThanATickLooksAt", 0,
       [](World& w) {
         w.add(shapes::sphere(0.04, 12));
         for (int i = 0; i < 2 * kMaxNear; ++i)
           w.add(shapes::sphere(0.006, 2), Vec3(0, 0.002 * (i % 32) - 0.03, 0.045));
       }},
      {"OneThatLeavesAcrossIt", 30,
       [](World& w) {
         w.add(shapes::sphere(0.04, 12));
         w.add(shapes::box({0.02, 0.02, 0.1}), kAslant);
         w.bodies()[1].pendingRemoval = true;
       }},
      {"CrossedMesh", kNever,
       [](World& w) {
         shapes::Shape s = shapes::bumpy(0.03, 8);
         s.add(shapes::box({0.02, 0.02, 0.08}, 4), Vec3(0.01, 0.004, 0));
         w.add(s);
       }},
      {"OneThatTurns", kNever, [](World& w) { w.add(shapes::bumpy(0.04, 12)); },
       [](World& w, int i) {
         w.move(0, {glm::angleAxis(0.001 * i, glm::normalize(Vec3(1, 2, 3))), Vec3(0)});
       }},
      {"OneThatTurnsElsewhere", kNever,
       [](World& w) {
         w.add(shapes::sphere(0.04, 12));
         w.add(shapes::bumpy(0.02, 8), kFar);
       },
       [](World& w, int i) {
         w.move(1, {glm::angleAxis(0.001 * i, glm::normalize(Vec3(1, 2, 3))), kFar.position});
       }},
  };
}

class FollowUnblocked : public testing::TestWithParam<Scene> {};

TEST_P(FollowUnblocked, GivesTheBitsOfTheLongWay) {
  constexpr int kTicks = 12'000;
  World world;
  GetParam().fill(world);
  std::mt19937_64 random(5);
  std::normal_distribution<double> push(0, 1);
  Vec3 hip{0.001, 0.002, 0.09};
  Vec3 speed(0);  // m per tick
  world.place(hip);
  int touching = 0;
  int shortWays = 0;
  for (int i = 0; i < kTicks; ++i) {
    const double pace = std::array{0.0001, 0.00001, 0.0004}[static_cast<std::size_t>(i / 500) % 3];
    speed = speed * 0.9 + Vec3(push(random), push(random), push(random)) * pace * 0.4;
    if (glm::length(hip) > 0.036) speed -= hip * (pace * 3);
    hip += speed;
    GetParam().animate(world, i);

    world.state().clear = {};  // a free tick of the long way has queries to count
    const ContactState before = world.state();
    const std::vector<Body> bodiesBefore = world.bodies();
    const ContactResult result = world.tick(hip);
    std::vector<Body> bodies = bodiesBefore;
    for (Body& body : bodies) body.update();

    ContactState longWay = before;
    ContactResult expected;
    followGuarded(bodies, longWay, hip, expected);
    ASSERT_NO_FATAL_FAILURE(expectSame(result, expected)) << "tick " << i;
    ASSERT_NO_FATAL_FAILURE(expectSame(world.state(), longWay)) << "tick " << i;
    touching += result.touching ? 1 : 0;
    ContactState shortWay = before;
    ContactResult found;
    const bool taken = followFast(bodies, shortWay, hip, found, nullptr);
    ASSERT_NO_FATAL_FAILURE(expectSame(shortWay, longWay)) << "tick " << i;
    shortWays += taken ? 1 : 0;
  }
  EXPECT_GT(touching, kTicks / 50);
  EXPECT_GE(shortWays * 100, touching * GetParam().leastShort);
  if (GetParam().leastShort == kNever) {
    EXPECT_EQ(shortWays, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, FollowUnblocked, testing::ValuesIn(scenes()),
                         [](const auto& scene) { return scene.param.name; });

}  // namespace
}  // namespace haptics::follow_unblocked_test

// Random motion at up to 2 m/s over everything: the IHIP is never inside of any body, and so, being the HIP when free,
// no contact is ever lost.

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/neighborhood_watch.h"
#include "tests/haptic_server/engine/contact/contact_rig.h"

namespace haptics::random_walk_test {
namespace {

struct Scene {
  const char* name;
  friend std::ostream& operator<<(std::ostream& out, const Scene& scene) { return out << scene.name; }
  std::function<void(ContactRig&)> fill;
  std::function<void(ContactRig&, int tick)> animate = [](ContactRig&, int) {};
};

Pose turning(int tick, double speed, Vec3 position) {
  return {glm::angleAxis(0.001 * speed * tick, glm::normalize(Vec3(1, 2, 3))), position};
}

std::vector<Scene> scenes() {
  return {
      {"sphere", [](ContactRig& w) { w.add(shapes::sphere(0.04, 12)); }},
      {"torus", [](ContactRig& w) { w.add(shapes::torus(0.035, 0.012, 40, 20)); }},
      {"cube",
       [](ContactRig& w) {
         w.add(shapes::box({0.07, 0.07, 0.07}, 3));
       }},
      {"bumpy", [](ContactRig& w) { w.add(shapes::bumpy(0.04, 12)); }},
      {"plate",
       [](ContactRig& w) {
         w.add(shapes::box({0.08, 0.08, 0.0005}, 6));
       }},
      {"comb", [](ContactRig& w) { w.add(shapes::comb(7, 0.01, 0.006, 0.05, 0.05)); }},
      {"overlapping boxes",
       [](ContactRig& w) {
         w.add(shapes::box({0.06, 0.06, 0.03}, 2));
         w.add(shapes::box({0.03, 0.03, 0.06}, 3), Vec3(0.011, 0.007, 0.012));
         w.add(shapes::box({0.09, 0.01, 0.01}, 4), Vec3(0, -0.01, 0.017));
       }},
      {"overlapping spheres",
       [](ContactRig& w) {
         w.add(shapes::sphere(0.03, 10), Vec3(0.015, 0, 0));
         w.add(shapes::sphere(0.03, 10), Vec3(-0.015, 0.01, 0));
         w.add(shapes::bumpy(0.03, 8), Vec3(0, -0.02, 0.01));
       }},
      {"self-crossing",
       [](ContactRig& w) {
         shapes::Shape s = shapes::bumpy(0.03, 8);
         s.add(shapes::box({0.02, 0.02, 0.08}, 4), Vec3(0.01, 0.004, 0));
         w.add(s);
       }},
      {"moving and overlapping",
       [](ContactRig& w) {
         w.add(shapes::box({0.05, 0.05, 0.02}, 2));
         w.add(shapes::torus(0.03, 0.01, 20, 10));
         w.add(shapes::sphere(0.02, 8));
       },
       [](ContactRig& w, int i) {
         w.move(0, turning(i, 1, {0.01 * std::sin(0.003 * i), 0, 0}));
         w.move(1, turning(-i, 2, {0, 0.015 * std::sin(0.002 * i), 0.01}));
       }},
  };
}

class RandomWalk : public testing::TestWithParam<Scene> {};

TEST_P(RandomWalk, IhipIsNeverInsideABody) {
  constexpr double kDeepest = 2e-7;  // m: the skin of these scenes and the vertices' rounding
  constexpr int kTicks = 20'000;
  ContactRig world;
  GetParam().fill(world);
  std::mt19937_64 random(11);
  std::normal_distribution<double> push(0, 1);
  Vec3 hip{0.001, 0.002, 0.09};
  Vec3 speed(0);  // m per tick
  world.place(hip);
  int touching = 0;
  int notConverged = 0;
  for (int i = 0; i < kTicks; ++i) {
    // A hand that wanders about the middle of the scene; its pace changes every half second.
    const double pace = std::array{0.0001, 0.00002, 0.001}[static_cast<std::size_t>(i / 500) % 3];
    speed = speed * 0.9 + Vec3(push(random), push(random), push(random)) * pace * 0.4;
    if (glm::length(hip) > 0.04) speed -= hip * (pace * 3);
    if (glm::length(speed) > 0.002) speed *= 0.002 / glm::length(speed);
    hip += speed;
    GetParam().animate(world, i);
    const ContactResult r = world.tick(hip);
    ASSERT_TRUE(isFinite(r.ihip)) << "tick " << i;
    ASSERT_LT(world.depthInside(r.ihip), kDeepest)
        << "tick " << i << " mode " << static_cast<int>(ContactState::Mode(world.state().mode));
    ASSERT_TRUE(r.touching || r.ihip == hip);
    ASSERT_LE(r.work.triangles, kSearchBudget + 48);
    ASSERT_EQ(r.work.droppedBodies, 0);
    touching += r.touching ? 1 : 0;
    notConverged += r.work.notConverged ? 1 : 0;
  }
  EXPECT_GT(touching, kTicks / 20);
  EXPECT_LT(notConverged, kTicks / 50);
}

INSTANTIATE_TEST_SUITE_P(Scenes, RandomWalk, testing::ValuesIn(scenes()), [](const auto& scene) {
  std::string name = scene.param.name;
  std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
  return name;
});

TEST(RandomWalkDeterminism, SameInputGivesTheSameBits) {
  const auto run = [] {
    ContactRig world;
    scenes()[8].fill(world);
    world.place({0, 0, 0.09});
    std::mt19937_64 random(3);
    std::normal_distribution<double> push(0, 0.0005);
    std::vector<Vec3> ihips;
    Vec3 hip{0, 0, 0.09};
    for (int i = 0; i < 2000; ++i) {
      hip = hip * 0.999 + Vec3(push(random), push(random), push(random));
      ihips.push_back(world.tick(hip).ihip);
    }
    return ihips;
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace haptics::random_walk_test

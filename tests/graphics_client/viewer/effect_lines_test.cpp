#include "graphics_client/viewer/effect_lines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace haptics::effect_lines_test {
namespace {

using Kind = Effect::Kind;
const std::vector<Vec3> kPath{{0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}};

double fromAxis(Vec3 p) { return std::hypot(p.y, p.z); }

TEST(EffectLines, DrawHowFarASpringTakesHold) {
  const Vec3 at(0.1, 0.2, 0.3);
  const auto ball = effectLines({.kind = Kind::kSpringToPoint, .point_m = at, .reach_m = 0.05});
  double farthest = 0;
  for (const Vec3 p : ball) farthest = std::max(farthest, glm::distance(p, at));
  EXPECT_NEAR(farthest, 0.05, 1e-9);
  const auto without = effectLines({.kind = Kind::kSpringToPoint, .point_m = at});
  EXPECT_LT(without.size(), ball.size());
  EXPECT_FALSE(without.empty()) << "its place is shown";
}

TEST(EffectLines, DrawTubesAndReachesRoundTheirPath) {
  for (const Effect& effect : {Effect{.kind = Kind::kTube, .path_m = kPath, .size_m = Vec3(0.04, 0, 0)},
                               Effect{.kind = Kind::kSpringToPath, .path_m = kPath, .reach_m = 0.02}}) {
    const auto lines = effectLines(effect);
    ASSERT_EQ(lines.size() % 2, 0U);
    const auto round = std::ranges::count_if(lines, [](Vec3 p) { return std::abs(fromAxis(p) - 0.02) < 1e-9; });
    const auto on = std::ranges::count_if(lines, [](Vec3 p) { return fromAxis(p) < 1e-9; });
    EXPECT_EQ(on, 4) << "the path itself";
    EXPECT_EQ(static_cast<std::size_t>(round + on), lines.size());
    const auto inMiddle =
        std::ranges::count_if(lines, [](Vec3 p) { return std::abs(p.x - 0.1) < 1e-9 && fromAxis(p) > 0; });
    EXPECT_GT(round, 3 * 32);
    EXPECT_EQ(inMiddle > 0, effect.kind == Kind::kTube) << "what reaches round a path hides it at its ends only";
  }
}

TEST(EffectLines, OfAPathOfManyPointsThereAreNoMoreRings) {
  Effect tube{.kind = Kind::kTube, .size_m = Vec3(0.04, 0, 0)};
  for (int i = 0; i < 4096; ++i) tube.path_m.emplace_back(1e-4 * i, 0, 0);
  EXPECT_LE(effectLines(tube).size(), 2 * 4095U + 12 * 64);
}

TEST(EffectLines, DrawRegionsAtTheirSize) {
  Effect fluid{.kind = Kind::kViscosity, .point_m = Vec3(1, 0, 0), .damping_Ns_per_m = 1};
  EXPECT_TRUE(effectLines(fluid).empty()) << "it is everywhere";
  fluid.region = Effect::Region::kBox;
  fluid.size_m = Vec3(0.2, 0.4, 0.6);
  const auto box = effectLines(fluid);
  EXPECT_EQ(box.size(), 24U);
  for (const Vec3 p : box) EXPECT_LT(glm::distance(glm::abs(p - fluid.point_m), fluid.size_m / 2.0), 1e-12);
  fluid.region = Effect::Region::kSphere;
  for (const Vec3 p : effectLines(fluid)) EXPECT_NEAR(glm::distance(p, fluid.point_m), 0.1, 1e-9);
}

TEST(EffectLines, AnArrowHasAHeadFromAnywhere) {
  const auto lines = effectLines({.kind = Kind::kForbiddenSide, .direction = Vec3(0, 0, 1)});
  for (const double turn : {0.0, 0.4, 0.8, 1.2, 1.6}) {  // seen from the side
    const Vec3 right(std::cos(turn), std::sin(turn), 0);
    double widest = 0;
    for (const Vec3 p : lines) widest = p.z > 0.01 ? std::max(widest, std::abs(glm::dot(p, right))) : widest;
    EXPECT_GT(widest, 1e-3) << turn;
  }
}

TEST(EffectLines, EveryKindWithAPlaceIsDrawn) {
  for (int kind = 1; kind < static_cast<int>(Kind::kRecordedTexture); ++kind) {
    if (kind >= static_cast<int>(Kind::kMagnet) && kind <= static_cast<int>(Kind::kSpringToEdge)) continue;  // the mesh
    const Effect effect{.kind = static_cast<Kind>(kind),
                        .direction = Vec3(0, 0, 1),
                        .path_m = kPath,
                        .reach_m = 0.01,
                        .region = Effect::Region::kSphere,
                        .size_m = Vec3(0.1)};
    const auto lines = effectLines(effect);
    EXPECT_FALSE(lines.empty()) << kind;
    EXPECT_TRUE(std::ranges::all_of(lines, [](Vec3 p) { return std::isfinite(p.x + p.y + p.z); })) << kind;
  }
}

}  // namespace
}  // namespace haptics::effect_lines_test

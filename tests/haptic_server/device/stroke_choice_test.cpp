#include "haptic_server/device/stroke_choice.h"

#include <gtest/gtest.h>

#include <random>

#include "haptic_server/device/exploration_plan.h"
#include "tests/haptic_server/device/analytic_scene.h"

namespace haptics::test::stroke_choice_test {
namespace {

constexpr double kCos50 = 0.6428;

TopView from(const Solid& solid) {
  return [&solid](double x, double y) { return solid.top(x, y); };
}

std::vector<Vec3> chooseOn(const Solid& solid) { return chooseStroke(from(solid), solid.low, solid.high); }

double length(const std::vector<Vec3>& stroke) { return glm::distance(stroke.front(), stroke.back()); }

void expectWellFormed(const std::vector<Vec3>& stroke, const Solid& solid) {
  ASSERT_GE(stroke.size(), 1U);
  ASSERT_LE(stroke.size(), kMaxStrokePoints);
  const auto flat = [](Vec3 step) { return Vec3(step.x, step.y, 0); };
  for (std::size_t i = 0; i < stroke.size(); ++i) {
    EXPECT_NEAR(solid.distance(stroke[i]), 0, 1e-6);
    EXPECT_GE(solid.normal(stroke[i]).z, kCos50 - 1e-6);
    if (i >= 2) {  // evenly spaced, seen from above
      EXPECT_LT(glm::distance(flat(stroke[i] - stroke[i - 1]), flat(stroke[i - 1] - stroke[i - 2])), 1e-9);
    }
  }
}

TEST(StrokeChoice, RunsAlongTheTopOfABoxAwayFromItsEdges) {
  const Vec3 centre(0.1, -0.2, 0.3), half(0.04, 0.03, 0.02);
  const Solid solid = box(1, centre, half);
  const auto stroke = chooseOn(solid);
  expectWellFormed(stroke, solid);
  EXPECT_GT(length(stroke), 0.04);
  EXPECT_LT(glm::distance((stroke.front() + stroke.back()) / 2.0, centre + Vec3(0, 0, half.z)), 0.005);
  for (const Vec3 p : stroke) {
    EXPECT_NEAR(p.z, centre.z + half.z, 1e-6);
    EXPECT_LT(std::abs(p.x - centre.x), half.x - 0.005);
    EXPECT_LT(std::abs(p.y - centre.y), half.y - 0.005);
  }
}

TEST(StrokeChoice, StaysNearTheTopOfASphere) {
  const Solid solid = sphere(1, {0, 0, 0.05}, 0.05);
  const auto stroke = chooseOn(solid);
  expectWellFormed(stroke, solid);
  EXPECT_GT(length(stroke), 0.03);
  EXPECT_LT(length(stroke), 0.06);
  EXPECT_LT(std::abs(stroke[stroke.size() / 2].x), 0.005);
  EXPECT_LT(std::abs(stroke[stroke.size() / 2].y), 0.005);
}

TEST(StrokeChoice, FollowsATorusAroundItsHole) {
  const Solid solid = torus(1, {0, 0, 0}, 0.04, 0.015);
  const auto stroke = chooseOn(solid);
  expectWellFormed(stroke, solid);
  EXPECT_GT(length(stroke), 0.02);
  for (const Vec3 p : stroke) EXPECT_GT(p.z, 0.009);
}

TEST(StrokeChoice, WorksOnBoxesTurnedAndTilted) {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> turn(-3.1, 3.1), tilt(-0.6, 0.6);
  for (int i = 0; i < 20; ++i) {
    const Pose pose{glm::angleAxis(tilt(engine), Vec3(1, 0, 0)) * glm::angleAxis(turn(engine), Vec3(0, 0, 1)),
                    Vec3(0.1, 0.2, 0.3)};
    const Solid straight = box(1, Vec3(0), {0.05, 0.04, 0.03});
    const Vec3 reach(glm::length(Vec3(0.05, 0.04, 0.03)));
    const Solid solid{1, [=](Vec3 p) { return straight.distance(toLocal(pose, p)); }, pose.position - reach,
                      pose.position + reach};
    const auto stroke = chooseOn(solid);
    expectWellFormed(stroke, solid);
    EXPECT_GT(length(stroke), 0.02) << i;
  }
}

TEST(StrokeChoice, WorksAtEverySize) {
  for (const double size : {1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0}) {
    for (const Solid& solid :
         {box(1, Vec3(0), Vec3(size)), sphere(1, Vec3(0), size), torus(1, Vec3(0), size, size / 3)}) {
      const auto view = [&solid, size](double x, double y) {
        auto top = solid.top(x, y);
        if (top) top->normal = solid.normal(top->position);
        return top;
      };
      const auto stroke = chooseStroke(view, solid.low, solid.high);
      ASSERT_FALSE(stroke.empty()) << size;
      EXPECT_LE(stroke.size(), kMaxStrokePoints);
      EXPECT_LE(length(stroke), 0.075) << size;  // 0.05 m seen from above
    }
  }
}

TEST(StrokeChoice, KeepsOffWhatIsHidden) {
  const Solid solid = box(1, Vec3(0), {0.05, 0.05, 0.01});
  const auto half = [&](double x, double y) { return x < 0 ? solid.top(x, y) : std::nullopt; };
  const auto stroke = chooseStroke(half, solid.low, solid.high);
  expectWellFormed(stroke, solid);
  EXPECT_GT(length(stroke), 0.02);
  for (const Vec3 p : stroke) EXPECT_LT(p.x, -0.005);
}

TEST(StrokeChoice, DoesNotCrossASteep) {
  const auto stairs = [](double x, double y) -> std::optional<TopPoint> {
    return TopPoint{{x, y, 0.02 * std::floor(x / 0.015)}, {0, 0, 1}};
  };
  const auto stroke = chooseStroke(stairs, {-0.1, -0.02, -0.2}, {0.1, 0.02, 0.2});
  ASSERT_FALSE(stroke.empty());
  for (const Vec3 p : stroke) EXPECT_EQ(p.z, stroke.front().z);
}

TEST(StrokeChoice, TakesANarrowRidgeWhenThereIsNothingElse) {
  const auto ridge = [](double x, double y) -> std::optional<TopPoint> {
    return std::abs(y) < 0.001 ? std::optional(TopPoint{{x, y, 0}, {0, 0, 1}}) : std::nullopt;
  };
  EXPECT_GT(length(chooseStroke(ridge, {-0.02, -0.02, -1e-3}, {0.02, 0.02, 1e-3})), 0.02);
}

TEST(StrokeChoice, PrefersALongNarrowPlaceToAShortWideOne) {
  const auto islands = [](double x, double y) -> std::optional<TopPoint> {
    const bool strip = std::abs(y) < 0.003;
    const bool patch = std::hypot(x - 0.03, y - 0.03) < 0.008;
    return strip || patch ? std::optional(TopPoint{{x, y, 0}, {0, 0, 1}}) : std::nullopt;
  };
  EXPECT_GT(length(chooseStroke(islands, {-0.04, -0.04, -1e-3}, {0.04, 0.04, 1e-3})), 0.04);
}

TEST(StrokeChoice, FindsNothingWhereNothingCanBePressed) {
  const auto nothing = [](double, double) { return std::optional<TopPoint>(); };
  const auto cliff = [](double x, double y) { return std::optional(TopPoint{{x, y, 3 * x}, {0.95, 0, 0.31}}); };
  const Vec3 low(-0.05), high(0.05);
  EXPECT_TRUE(chooseStroke(nothing, low, high).empty());
  EXPECT_TRUE(chooseStroke(cliff, low, high).empty());
  const Solid solid = box(1, Vec3(0), Vec3(0.01));
  EXPECT_TRUE(chooseStroke(from(solid), low, low).empty());  // a box without extent
}

TEST(StrokeChoice, RepeatsItselfBitForBit) {
  const Solid solid = torus(1, {0.3, 0.1, 0}, 0.04, 0.015);
  EXPECT_EQ(chooseOn(solid), chooseOn(solid));
}

}  // namespace
}  // namespace haptics::test::stroke_choice_test

#include "haptic_server/engine/tool/least_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <span>
#include <vector>

namespace haptics::least_distance_test {
namespace {

double dot(const Freedoms& a, const Freedoms& b) {
  double sum = 0;
  for (std::size_t i = 0; i < kMaxFreedoms; ++i) sum += a[i] * b[i];
  return sum;
}

/// @param freedoms  The other coordinates are 0.
std::vector<HalfSpace> randomHalfSpaces(std::mt19937_64& random, std::size_t count, std::size_t freedoms = 6) {
  std::normal_distribution<double> normal;
  std::vector<HalfSpace> all(count);
  Freedoms inside;
  for (double& x : inside) x = normal(random);
  for (HalfSpace& one : all) {
    one.normal = {};
    for (double& x : std::span(one.normal).first(freedoms)) x = normal(random);
    one.offset = dot(one.normal, inside) - std::abs(normal(random));
  }
  return all;
}

/// Hildreth's method: slow, and of a few lines. It ends where a sweep moves nothing by more than rounding does.
Freedoms nearestByRelaxation(const std::vector<HalfSpace>& all) {
  Freedoms x{};
  std::vector<double> multiplier(all.size());
  double moved = 1;
  for (int sweep = 0; sweep < 200'000 && moved > 1e-15; ++sweep) {
    moved = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double step =
          std::max(-multiplier[i], (all[i].offset - dot(all[i].normal, x)) / dot(all[i].normal, all[i].normal));
      multiplier[i] += step;
      moved = std::max(moved, std::abs(step));
      for (std::size_t k = 0; k < kMaxFreedoms; ++k) x[k] += step * all[i].normal[k];
    }
  }
  return x;
}

TEST(LeastDistance, IsThatOfASlowMethod) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 40; ++i) {
    const bool jointed = i >= 20;
    const auto all = randomHalfSpaces(random, jointed ? 14 : 12, jointed ? 7 : 6);
    const LeastDistance nearest = jointed ? leastDistance<7>(all) : leastDistance(all);
    ASSERT_TRUE(nearest.exists);
    const Freedoms slow = nearestByRelaxation(all);
    for (std::size_t k = 0; k < kMaxFreedoms; ++k) EXPECT_NEAR(nearest.x[k], slow[k], 1e-6);
  }
}

TEST(LeastDistance, IsInAllHalfSpacesAndHeldByThoseItNames) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 4000; ++i) {
    const bool jointed = i >= 2000;
    const auto all = randomHalfSpaces(random, 1 + static_cast<std::size_t>(i) % 200, jointed ? 7 : 6);
    const LeastDistance nearest = jointed ? leastDistance<7>(all) : leastDistance(all);
    ASSERT_TRUE(nearest.exists);
    for (const HalfSpace& one : all) EXPECT_GE(dot(one.normal, nearest.x) - one.offset, -1e-9);
    for (int t = 0; t < nearest.tightCount; ++t) {
      const HalfSpace& one = all[nearest.tight[static_cast<std::size_t>(t)]];
      EXPECT_NEAR(dot(one.normal, nearest.x), one.offset, 1e-9);
    }
  }
}

TEST(LeastDistance, IsNoneWhereHalfSpacesExcludeEachOther) {
  const std::vector<HalfSpace> apart{{{0, 1, 0, 0, 0, 0, 0}, 1}, {{0, -1, 0, 0, 0, 0, 0}, 1}};
  EXPECT_FALSE(leastDistance(apart).exists);
}

TEST(LeastDistance, OfTheSameHalfSpaceManyTimesIsThatOfOne) {
  const std::vector<HalfSpace> same(500, {{0, 0, 2, 0, 0, 0, 0}, 1e-5});
  const LeastDistance nearest = leastDistance(same);
  ASSERT_TRUE(nearest.exists);
  EXPECT_NEAR(nearest.x[2], 5e-6, 1e-18);
  EXPECT_EQ(nearest.tightCount, 1);
}

TEST(LeastDistance, IsFiniteWhereHalfSpacesHaveNoNormalOrTie) {
  std::vector<HalfSpace> all{{{}, 1}};  // of a triangle without area
  EXPECT_EQ(leastDistance(all).x, Freedoms{});
  for (const double x : {-1.0, 1.0}) {  // a face of a cube on a plane: a force, and moments about both axes
    for (const double y : {-1.0, 1.0}) all.push_back({{0, 0, 1, y, -x, 0, 0}, 1e-5});
  }
  const LeastDistance nearest = leastDistance(all);
  ASSERT_TRUE(nearest.exists);
  const Freedoms up{0, 0, 1e-5};
  for (std::size_t k = 0; k < kMaxFreedoms; ++k) EXPECT_NEAR(nearest.x[k], up[k], 1e-15);
  for (int i = 0; i < nearest.tightCount; ++i)
    EXPECT_TRUE(std::isfinite(nearest.multiplier[static_cast<std::size_t>(i)]));
}

TEST(LeastDistance, IsTheOriginWhereNothingIsInItsWay) {
  EXPECT_EQ(leastDistance({}).x, Freedoms{});
  const std::vector<HalfSpace> below{{{0, 0, 1, 0, 0, 0, 0}, -1}};
  EXPECT_EQ(leastDistance(below).x, Freedoms{});
}

}  // namespace
}  // namespace haptics::least_distance_test

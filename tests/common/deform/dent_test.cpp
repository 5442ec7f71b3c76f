#include "common/deform/dent.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "common/deform/soft_tissue.h"

namespace haptics::dent_test {
namespace {

TEST(Falloff, IsOneAtTheCentreNothingAtTheRimAndSmoothThere) {
  for (unsigned degree = Falloff::kMinDegree; degree <= Falloff::kMaxDegree; ++degree) {
    const Falloff falloff(0.01, degree);
    EXPECT_EQ(falloff.at(Vec3(0)), 1);
    EXPECT_EQ(falloff.at({0.01, 0, 0}), 0);
    EXPECT_EQ(falloff.at({0, 0.02, 0}), 0);
    const double step = 1e-7;
    EXPECT_LT(falloff.at({0, 0, 0.01 - step}) / step, 1e-2) << "slope at the rim, per metre, of degree " << degree;
    EXPECT_LT((1 - falloff.at({0, 0, step})) / step, 1e-1);
  }
}

TEST(Falloff, IsNowhereSteeperThanItSays) {
  for (unsigned degree = Falloff::kMinDegree; degree <= Falloff::kMaxDegree; ++degree) {
    const Falloff falloff(0.02, degree);
    double steepest = 0;
    for (int i = 1; i < 20000; ++i) {
      const double a = i * 1e-6, b = a + 1e-6;
      steepest = std::max(steepest, (falloff.at({a, 0, 0}) - falloff.at({b, 0, 0})) / 1e-6);
    }
    EXPECT_LE(steepest, falloff.maxSlope_per_m() * (1 + 1e-9));
    EXPECT_GT(steepest, falloff.maxSlope_per_m() * 0.999);
  }
}

TEST(Dent, LeavesWhatIsBeyondItsRadiusToTheBit) {
  const Falloff falloff(0.005, 2);
  const std::array dents{Dent{{0, 0, 0.05F}, {0, 0, -0.001F}}};
  const Vec3f far(0.1F, 0.0301F, 1e-20F);
  EXPECT_EQ(dented(far, dents, falloff), far);
  EXPECT_NEAR(dented({0, 0, 0.05F}, dents, falloff).z, 0.049, 1e-8);
}

TEST(Dent, ComeOneAfterAnotherSoThatTheFirstOfThemMayBecomeTheShapeAtRest) {
  const Falloff falloff(0.01, 2);
  const std::array dents{Dent{{0, 0, 0.05F}, {0.0002F, 0, -0.003F}}, Dent{{0.004F, 0, 0.049F}, {0, 0.0001F, -0.002F}},
                         Dent{{0.002F, 0.003F, 0.0477F}, {0, 0, -0.001F}}};
  for (int i = 0; i < 1000; ++i) {
    const Vec3f rest(0.00002F * float(i), 0.000013F * float(i % 77), 0.05F);
    const Vec3f taken = dented(rest, std::span(dents).first(2), falloff);
    EXPECT_EQ(dented(taken, std::span(dents).last(1), falloff), dented(rest, dents, falloff));
  }
}

TEST(Falloff, TwoSideBySideAreAboutAsDeepBetweenThemAsAtTheirCentres) {
  for (unsigned degree = Falloff::kMinDegree; degree <= Falloff::kMaxDegree; ++degree) {
    const Falloff falloff(0.01, degree);
    EXPECT_NEAR(2 * falloff.at({falloff.width_m() / 2, 0, 0}), 1, 1e-9);
    EXPECT_LT(falloff.at({falloff.width_m(), 0, 0}), 0.05) << "hardly felt at the other's centre";
  }
}

/// Corners of a triangle with no angle above 120 degrees.
std::array<Vec3, 3> triangle(std::mt19937& random) {
  std::uniform_real_distribution<double> place(-0.01, 0.01);
  while (true) {
    std::array<Vec3, 3> t;
    for (Vec3& corner : t) corner = {place(random), place(random), place(random)};
    const bool blunt = [&] {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 a = t[(k + 1) % 3] - t[k], b = t[(k + 2) % 3] - t[k];
        if (glm::dot(a, b) < -0.5 * glm::length(a) * glm::length(b)) return true;
      }
      return false;
    }();
    if (!blunt) return t;
  }
}

TEST(Dent, AsDeepAsTheyMayBeTheyTurnNoTriangleOver) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 200'000; ++i) {
    const std::array<Vec3, 3> rest = triangle(random);
    const Falloff falloff(0.002 + 0.01 * std::abs(unit(random)), 2 + static_cast<unsigned>(i) % 7);
    const int count = 1 + i % 3;
    std::array<Vec3, 3> now = rest;
    for (int d = 0; d < count; ++d) {
      const Vec3 centre(0.01 * unit(random), 0.01 * unit(random), 0.01 * unit(random));
      const Vec3 towards = glm::normalize(Vec3(unit(random), unit(random), unit(random) + 1e-9));
      const Dent dent{Vec3f(centre), Vec3f(towards * (maxDentDepth_m(falloff) / count))};
      for (std::size_t k = 0; k < 3; ++k) now[k] += displacementBy(dent, falloff, rest[k]);
    }
    const Vec3 before = glm::cross(rest[1] - rest[0], rest[2] - rest[0]);
    const Vec3 after = glm::cross(now[1] - now[0], now[2] - now[0]);
    ASSERT_GT(glm::dot(before, after), 0) << "triangle " << i;
  }
}

TEST(SoftTissue, GivesTheStiffnessOfSpringsInSeries) {
  const SoftTissue tissue{Falloff(0.01, 2), 300, 0};
  const double yielded = tissue.yield_m(0, 0.004, 700, 1e-3);
  EXPECT_NEAR(700 * (0.004 - yielded), 0.004 / (1 / 700.0 + 1 / 300.0), 1e-12);
  EXPECT_NEAR(300 * yielded, 700 * (0.004 - yielded), 1e-12);
  EXPECT_EQ(tissue.leftAfter(1e-3), 0);
}

TEST(SoftTissue, ViscousGoesTheSameWayInLongStepsAndInShortOnes) {
  const SoftTissue tissue{Falloff(0.01, 2), 300, 0.2};
  double slow = 0;
  for (int i = 0; i < 100; ++i) slow = tissue.yield_m(slow, 0.004, 700, 1e-3);
  EXPECT_NEAR(slow, tissue.yield_m(0, 0.004, 700, 0.1), 1e-12);
  EXPECT_NEAR(tissue.leftAfter(0.2), 1 / std::numbers::e, 1e-12);
  // Where the contact just holds, the tissue goes back as if nothing touched it.
  const double step = 1e-6;
  const double touched = (0.002 - tissue.yield_m(0.002, 0.002, 700, step)) / step;
  const double free = 0.002 * (1 - tissue.leftAfter(step)) / step;
  EXPECT_NEAR(touched, free, 1e-3 * free);
}

}  // namespace
}  // namespace haptics::dent_test

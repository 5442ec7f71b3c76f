#include "tests/stress/statistics.h"

#include <gtest/gtest.h>

namespace haptics::stress::statistics_test {
namespace {

TEST(PoissonP, IsOneWhereNothingCanBeTold) {
  EXPECT_EQ(poissonP(0, 1000, 0, 1000), 1);
  EXPECT_EQ(poissonP(5, 0, 7, 1000), 1);
}

TEST(PoissonP, IsTheExactBinomialTestGivenTheSum) {
  EXPECT_NEAR(poissonP(0, 1, 5, 1), 2 * std::pow(0.5, 5), 1e-12);
  EXPECT_NEAR(poissonP(1, 1, 9, 1), 2 * 11 / 1024.0, 1e-12);
  EXPECT_NEAR(poissonP(3, 1, 0, 3), 1 / 64.0, 1e-12);
}

TEST(PoissonP, TakesTheExposureIntoAccount) {
  EXPECT_GT(poissonP(10, 1000, 40, 4000), 0.9);
  EXPECT_LT(poissonP(10, 1000, 40, 1000), 0.001);
}

TEST(PoissonP, DoesNotDependOnWhichIsFirst) { EXPECT_NEAR(poissonP(3, 2, 11, 5), poissonP(11, 5, 3, 2), 1e-12); }

TEST(Percentile, IsTheNearestRank) {
  std::vector<double> values{4, 1, 3, 2};
  EXPECT_EQ(percentile(values, 0.5), 2);
  EXPECT_EQ(percentile(values, 0.99), 4);
  std::vector<double> none;
  EXPECT_EQ(percentile(none, 0.5), 0);
}

}  // namespace
}  // namespace haptics::stress::statistics_test

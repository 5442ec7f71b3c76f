#include <gtest/gtest.h>

#include "haptic_server/servo/latency_histogram.h"

namespace haptics::latency_histogram_tests {
namespace {

TEST(LatencyHistogram, FindsQuantilesToThreePercent) {
  LatencyHistogram histogram;
  for (std::uint64_t i = 1; i <= 100'000; ++i) histogram.record(i);
  for (const double part : {0.01, 0.5, 0.99, 0.999}) {
    const double truth = part * 100'000;
    EXPECT_GE(static_cast<double>(histogram.quantile_ns(part)), truth);
    EXPECT_LE(static_cast<double>(histogram.quantile_ns(part)), truth * 1.04);
  }
  EXPECT_EQ(histogram.max_ns(), 100'000);
  EXPECT_EQ(histogram.quantile_ns(1), 100'000);
}

TEST(LatencyHistogram, TakesEveryDurationFromZeroToTheLargest) {
  LatencyHistogram histogram;
  histogram.record(0);
  EXPECT_EQ(histogram.quantile_ns(0.5), 0);
  for (unsigned bit = 0; bit < 64; ++bit) {
    LatencyHistogram one;
    const std::uint64_t value = std::uint64_t{1} << bit;
    one.record(value);
    EXPECT_EQ(one.quantile_ns(0.5), value);
  }
  histogram.record(~std::uint64_t{0});
  EXPECT_EQ(histogram.max_ns(), ~std::uint64_t{0});
}

TEST(LatencyHistogram, LeavesNoMoreRecordsAboveAQuantileThanItsPart) {
  LatencyHistogram histogram;
  for (std::uint64_t i = 1; i <= 50; ++i) histogram.record(i);
  EXPECT_EQ(histogram.quantile_ns(0.99), 50);
}

TEST(LatencyHistogram, SaysZeroWhenEmpty) { EXPECT_EQ(LatencyHistogram().quantile_ns(0.99), 0); }

}  // namespace
}  // namespace haptics::latency_histogram_tests

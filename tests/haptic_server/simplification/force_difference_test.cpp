#include "haptic_server/simplification/force_difference.h"

#include <gtest/gtest.h>

#include "common/maths/perception.h"

namespace haptics::force_difference_test {
namespace {

TEST(ForceError, IsOneWhereAMagnitudeOrADirectionIsJustNoticeable) {
  EXPECT_NEAR(forceError_jnd({0, 0, 1.07}, {0, 0, 1}), 1, 1e-9);
  EXPECT_NEAR(forceError_jnd({0, 0, 0.15}, {0, 0, 0.1}), 1, 1e-9) << "7 % of so small a force means nothing";
  const double turn = kDirectionThreshold_deg * std::numbers::pi / 180;
  EXPECT_NEAR(forceError_jnd({std::sin(turn), 0, std::cos(turn)}, {0, 0, 1}), 1, 1e-9);
  EXPECT_EQ(forceError_jnd({0, 0, 1}, {0, 0, 1}), 0);
}

TEST(ForceDifference, CountsTicksWithContactInEither) {
  const Vec3 none(0), up(0, 0, 1);
  const ForceDifference difference = differenceOf({{none, up, none, none, -up}}, {{none, up, up, up, up}});
  EXPECT_EQ(difference.ticks, 4);
  EXPECT_EQ(difference.missedTicks, 1) << "one tick on end may be missed";
  EXPECT_EQ(difference.wrongSideTicks, 1);
  EXPECT_EQ(difference.felt_ratio, 0.75);
  EXPECT_FALSE(difference.good());
}

TEST(ForceDifference, OfNoContactIsNothing) {
  const ForceDifference difference = differenceOf({{Vec3(0)}}, {{Vec3(0)}});
  EXPECT_EQ(difference.ticks, 0);
  EXPECT_TRUE(difference.good());
}

}  // namespace
}  // namespace haptics::force_difference_test

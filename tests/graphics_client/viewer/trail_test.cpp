#include "graphics_client/viewer/trail.h"

#include <gtest/gtest.h>

namespace haptics::trail_test {
namespace {

TelemetrySample touching(std::uint64_t tick, std::uint64_t object) {
  TelemetrySample sample;
  sample.tick = tick;
  sample.object = object;
  sample.ihip = Vec3(static_cast<double>(tick), 0, 0);
  return sample;
}

TEST(Trail, KeepsOneSecondAndFades) {
  Trail trail;
  for (std::uint64_t tick = 0; tick <= 30; ++tick) trail.add(touching(tick + 1, 7), 0.1 * static_cast<double>(tick));
  ASSERT_FALSE(trail.points().empty());
  EXPECT_GE(trail.points().front().time_s, 2.0 - 1e-9);
  EXPECT_NEAR(trail.freshness(trail.points().back()), 1, 1e-9);
  EXPECT_NEAR(trail.freshness(trail.points().front()), 0, 0.11);
}

TEST(Trail, TakesASampleOnce) {
  Trail trail;
  trail.add(touching(5, 7), 0);
  trail.add(touching(5, 7), 0.1);
  EXPECT_EQ(trail.points().size(), 1U);
}

TEST(Trail, DoesNotJoinStrokesThatWereLiftedInBetween) {
  Trail trail;
  trail.add(touching(1, 7), 0);
  trail.add(touching(2, 7), 0.01);
  trail.add(touching(3, 0), 0.02);
  trail.add(touching(4, 7), 0.03);
  trail.add(touching(5, 8), 0.04);
  ASSERT_EQ(trail.points().size(), 4U);
  EXPECT_TRUE(trail.points()[0].startsStroke);
  EXPECT_FALSE(trail.points()[1].startsStroke);
  EXPECT_TRUE(trail.points()[2].startsStroke);
  EXPECT_TRUE(trail.points()[3].startsStroke);
}

TEST(Trail, StartsAgainWhenTheServerCountsItsTicksAnew) {
  Trail trail;
  trail.add(touching(1'000'000, 7), 0);
  trail.add(touching(3, 7), 0.1);
  EXPECT_EQ(trail.points().size(), 2U);
}

}  // namespace
}  // namespace haptics::trail_test

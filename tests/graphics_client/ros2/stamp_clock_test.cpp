#include "graphics_client/ros2/stamp_clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace haptics {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000, kSecond = 1'000 * kMillisecond;

TEST(StampClock, TakesTheFirstDifferenceAsItIs) {
  StampClock clock;
  clock.learn(5 * kSecond, 1);
  EXPECT_EQ(clock.stamp_ns(7), 5 * kSecond + 7);
}

TEST(StampClock, FollowsAnotherEstimateByAThousandthOfTheTime) {
  StampClock clock;
  clock.learn(0, 0);
  clock.learn(10 * kMillisecond, 1 * kSecond);
  EXPECT_EQ(clock.stamp_ns(0), 1 * kMillisecond);
  clock.learn(-10 * kMillisecond, 3 * kSecond);
  EXPECT_EQ(clock.stamp_ns(0), -1 * kMillisecond);
  clock.learn(0, 9 * kSecond);
  EXPECT_EQ(clock.stamp_ns(0), 0);
}

TEST(StampClock, NeverGoesBackForEstimatesThatJitter) {
  StampClock clock;
  std::int64_t last_ns = -kSecond;
  for (std::int64_t tick = 0; tick < 5000; ++tick) {
    const std::int64_t now_ns = tick * kMillisecond;
    clock.learn((tick * 7919 % 41 - 20) * kMillisecond, static_cast<std::uint64_t>(now_ns));
    const std::int64_t stamp_ns = clock.stamp_ns(static_cast<std::uint64_t>(now_ns));
    ASSERT_GT(stamp_ns, last_ns) << "tick " << tick;
    last_ns = stamp_ns;
  }
}

TEST(StampClock, FollowsAClockThatIsSetAtOnce) {
  StampClock clock;
  clock.learn(0, 0);
  clock.learn(-3600 * kSecond, 1);
  EXPECT_EQ(clock.stamp_ns(0), -3600 * kSecond);
}

}  // namespace
}  // namespace haptics

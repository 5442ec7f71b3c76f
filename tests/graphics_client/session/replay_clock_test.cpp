#include "graphics_client/session/replay_clock.h"

#include <gtest/gtest.h>

namespace haptics::replay_clock_test {
namespace {

TEST(ReplayClock, StandsStillUntilItPlaysAndStopsAtTheEnd) {
  ReplayClock clock(2);
  clock.advance(1);
  EXPECT_EQ(clock.time_s(), 0);
  clock.setPlaying(true);
  clock.advance(1.5);
  EXPECT_EQ(clock.time_s(), 1.5);
  EXPECT_TRUE(clock.isPlaying());
  clock.advance(1.5);
  EXPECT_EQ(clock.time_s(), 2);
  EXPECT_FALSE(clock.isPlaying());
}

TEST(ReplayClock, PlaysFromTheBeginningOnceItIsAtTheEnd) {
  ReplayClock clock(2);
  clock.seek(2);
  clock.setPlaying(true);
  EXPECT_EQ(clock.time_s(), 0);
}

TEST(ReplayClock, SeeksWithinTheRecordingOnly) {
  ReplayClock clock(2);
  clock.seek(5);
  EXPECT_EQ(clock.time_s(), 2);
  clock.seek(-1);
  EXPECT_EQ(clock.time_s(), 0);
}

TEST(ReplayClock, PlaysSlowlyWhereItIsTold) {
  ReplayClock clock(2);
  clock.setSpeed(0);
  clock.setPlaying(true);
  clock.advance(1);
  EXPECT_DOUBLE_EQ(clock.time_s(), 0.1);
  clock.setSpeed(99);
  EXPECT_EQ(ReplayClock::kSpeeds[clock.speed()], 1.0);
}

}  // namespace
}  // namespace haptics::replay_clock_test

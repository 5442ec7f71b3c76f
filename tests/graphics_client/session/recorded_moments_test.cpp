#include "graphics_client/session/recorded_moments.h"

#include <gtest/gtest.h>

namespace haptics::recorded_moments_test {
namespace {

/// Adds what is wanted of ticks at 1 kHz.
void fill(RecordedMoments& moments, int ticks, const std::shared_ptr<const RecordedMotion>& motion = nullptr) {
  for (int tick = 0; tick < ticks; ++tick) {
    const double time_s = tick / 1000.0;
    if (!moments.wants(time_s)) continue;
    RecordedMoment moment{time_s, {}, motion, 0};
    moment.sample.tick = static_cast<std::uint64_t>(tick);
    moments.add(std::move(moment));
  }
}

TEST(RecordedMoments, KeepsEveryFourthTickOfAKilohertz) {
  RecordedMoments moments;
  fill(moments, 10'000);
  ASSERT_EQ(moments.list().size(), 2500U);
  for (std::size_t i = 0; i < moments.list().size(); ++i) ASSERT_EQ(moments.list()[i].sample.tick, 4 * i);
}

TEST(RecordedMoments, KeepsEveryTickOfASlowerServo) {
  RecordedMoments moments;
  for (int tick = 0; tick < 100; ++tick) {
    ASSERT_TRUE(moments.wants(tick / 250.0)) << tick;
    moments.add({tick / 250.0, {}, nullptr, 0});
  }
}

TEST(RecordedMoments, ThinsOutEvenlyFromBeginningToEndWhereMemoryEnds) {
  constexpr std::size_t kRoom = 300 * sizeof(RecordedMoment);
  RecordedMoments moments(kRoom);
  fill(moments, 10'000);
  const auto& list = moments.list();
  EXPECT_LE(list.size() * sizeof(RecordedMoment), kRoom);
  EXPECT_GT(list.size(), 100U);
  EXPECT_EQ(list.front().sample.tick, 0U);
  EXPECT_GT(list.back().time_s, 9.9);
  for (std::size_t i = 1; i < list.size(); ++i) {
    ASSERT_NEAR(list[i].time_s - list[i - 1].time_s, moments.interval_s(), 1e-9) << i;
  }
}

TEST(RecordedMoments, WhatMovesCountsAsOftenAsItIsHeld) {
  constexpr std::size_t kRoom = 300 * sizeof(RecordedMoment);
  RecordedMotion many;
  many.bodies.resize(32);
  RecordedMoments shared(kRoom), each(kRoom);
  fill(shared, 1000, std::make_shared<const RecordedMotion>(many));
  for (int i = 0; i < 250; ++i) each.add({i / 250.0, {}, std::make_shared<const RecordedMotion>(many), 0});
  EXPECT_EQ(shared.list().size(), 250U);
  EXPECT_LT(each.list().size(), 130U);
}

TEST(RecordedMoments, FindsTheLastOneAtATimeOrBefore) {
  RecordedMoments moments;
  for (const double time_s : {0.0, 0.1, 0.5}) moments.add({time_s, {}, nullptr, 0});
  EXPECT_EQ(moments.indexAt(-1), 0U);
  EXPECT_EQ(moments.indexAt(0.05), 0U);
  EXPECT_EQ(moments.indexAt(0.1), 1U);
  EXPECT_EQ(moments.indexAt(0.499), 1U);
  EXPECT_EQ(moments.indexAt(0.5), 2U);
  EXPECT_EQ(moments.indexAt(100), 2U);
}

}  // namespace
}  // namespace haptics::recorded_moments_test

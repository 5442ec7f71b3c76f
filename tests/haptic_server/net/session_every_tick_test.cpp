#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "common/telemetry/tick_gaps.h"
#include "tests/haptic_server/net/session_world.h"

namespace haptics::session_every_tick_test {
namespace {

using namespace test;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Kind = v1::Envelope;

class SessionEveryTick : public ::testing::Test, public SessionWorld {
 protected:
  SessionEveryTick() {
    tickHistory.keep(true);
    join();
  }
  void subscribe(bool everyTick = true) {
    v1::Envelope envelope;
    envelope.mutable_subscribe()->set_every_tick(everyTick);
    client.send(envelope);
    link.settle();
  }
  void add(std::uint64_t number) {
    TelemetrySample sample;
    sample.tick = number;
    tickHistory.add(sample, nullptr);
  }
  /// At 1 kHz.
  void tick(std::uint64_t first, std::uint64_t last) {
    for (std::uint64_t number = first; number <= last; ++number) {
      add(number);
      time_ns += kMillisecond_ns;
      session.poll();
      link.settle();
    }
  }
  [[nodiscard]] std::vector<v1::Telemetry> samples() const {
    std::vector<v1::Telemetry> all;
    for (const auto& envelope : client.all(Kind::kTelemetryBatch)) {
      const auto& batch = envelope.telemetry_batch().sample();
      all.insert(all.end(), batch.begin(), batch.end());
    }
    return all;
  }
  [[nodiscard]] std::vector<std::uint64_t> ticks() const {
    std::vector<std::uint64_t> numbers;
    for (const v1::Telemetry& sample : samples()) numbers.push_back(sample.tick());
    return numbers;
  }
};

TEST_F(SessionEveryTick, SendsEachOneOnceInOrderInBatches) {
  tick(1, 5);
  subscribe();
  tick(6, 1000);
  pass(TickBatches::kEvery_ns);
  std::vector<std::uint64_t> all(995);
  std::iota(all.begin(), all.end(), 6);
  EXPECT_EQ(ticks(), all);
  EXPECT_LT(client.all(Kind::kTelemetryBatch).size(), 120U);
}

TEST_F(SessionEveryTick, SendsNoneUnaskedNorOnceTheyAreNoLongerWanted) {
  tick(1, 50);
  EXPECT_THAT(ticks(), IsEmpty());
  subscribe();
  tick(51, 100);
  subscribe(false);
  const auto before = ticks().size();
  tick(101, 200);
  EXPECT_EQ(ticks().size(), before);
}

TEST_F(SessionEveryTick, HoldsWhatASecondHandFeltInTheSameTick) {
  subscribe();
  TelemetrySample sample;
  for (sample.tick = 1; sample.tick <= 3; ++sample.tick) tickHistory.add(sample, nullptr);
  TelemetrySample second = sample;
  second.penetration_m = 0.5;
  tickHistory.add(sample, &second);
  pass(TickBatches::kEvery_ns);
  const auto got = samples();
  ASSERT_EQ(got.size(), 4U);
  EXPECT_FALSE(got[0].has_second_hand());
  EXPECT_EQ(got[3].second_hand().penetration_m(), 0.5);
}

TEST_F(SessionEveryTick, SaysWhichBatchReachesTheNewestTick) {
  subscribe();
  for (std::uint64_t number = 1; number <= 2 * TickBatches::kTicks + 1; ++number) add(number);
  pass(2 * TickBatches::kEvery_ns);
  std::vector<bool> reaches;
  for (const auto& envelope : client.all(Kind::kTelemetryBatch))
    reaches.push_back(envelope.telemetry_batch().reaches_newest());
  EXPECT_THAT(reaches, ElementsAre(false, false, true));
}

TEST_F(SessionEveryTick, ALineThatStandsStillLosesTheOldestAndItsClientCanTell) {
  subscribe();
  tick(1, 20);
  for (std::uint64_t number = 21; number <= 20 + 3 * TickHistory::kTicks; ++number) {
    add(number);
    session.poll();
  }
  pass(kSecond_ns);
  const auto got = ticks();
  ASSERT_FALSE(got.empty());
  EXPECT_EQ(got.back(), 20 + 3 * TickHistory::kTicks);
  TickGaps gaps;
  std::vector<std::uint64_t> lost;
  for (const std::uint64_t number : got) {
    if (const auto gap = gaps.next(number, 0)) lost.push_back(gap->lost);
  }
  EXPECT_THAT(lost, ElementsAre(20 + 3 * TickHistory::kTicks - got.size()));
  EXPECT_FALSE(over) << "it is not turned away for that";
}

TEST(TickHistory, KeepsNothingWhileNobodyWantsIt) {
  TickHistory history;
  history.add({}, nullptr);
  EXPECT_EQ(history.end(), 0U);
  history.keep(true);
  history.add({}, nullptr);
  history.keep(false);
  EXPECT_EQ(history.begin(), history.end());
}

TEST(TickGaps, TellApartWhatTheServoMissedAndWhatWasLost) {
  TickGaps gaps;
  EXPECT_FALSE(gaps.next(10, 5));
  EXPECT_FALSE(gaps.next(11, 5));
  const auto gap = gaps.next(20, 8);
  ASSERT_TRUE(gap);
  EXPECT_EQ(gap->inWords(), "after tick 11: 3 missed by the servo, 5 lost on the way");
  EXPECT_FALSE(gaps.next(1, 0)) << "the server has started anew";
  EXPECT_EQ(gaps.missed(), 3U);
  EXPECT_EQ(gaps.lost(), 5U);
}

}  // namespace
}  // namespace haptics::session_every_tick_test

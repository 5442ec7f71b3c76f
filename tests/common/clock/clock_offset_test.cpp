#include "common/clock/clock_offset.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "common/clock/monotonic.h"

namespace haptics::clock_offset_test {
namespace {

constexpr std::int64_t kOffset_ns = 5'000'000'123;
constexpr std::int64_t kServerWork_ns = 40'000;

/// One probe sent at `clientSend`, with these ways there and back.
void probe(ClockOffset& clock, std::uint64_t clientSend, std::int64_t there_ns, std::int64_t back_ns,
           std::int64_t offset_ns = kOffset_ns) {
  const std::uint64_t receive = clientSend + there_ns + offset_ns;
  const std::uint64_t send = receive + kServerWork_ns;
  clock.add(clientSend, receive, send, clientSend + there_ns + kServerWork_ns + back_ns);
}

TEST(ClockOffset, KnowsNothingBeforeTheFirstProbe) { EXPECT_FALSE(ClockOffset().known()); }

TEST(ClockOffset, IsExactOverASymmetricLine) {
  ClockOffset clock;
  probe(clock, 1'000, 100'000'000, 100'000'000);
  EXPECT_TRUE(clock.known());
  EXPECT_EQ(clock.offset_ns(), kOffset_ns);
  EXPECT_EQ(clock.uncertainty_ns(), 100'000'000);
}

TEST(ClockOffset, MayBeNegative) {
  ClockOffset clock;
  probe(clock, 10'000'000'000, 1'000, 1'000, -kOffset_ns);
  EXPECT_EQ(clock.offset_ns(), -kOffset_ns);
  EXPECT_EQ(clock.toClient_ns(1'000), 1'000 + kOffset_ns);
}

TEST(ClockOffset, DoesNotCountTheServersWorkAsDelay) {
  ClockOffset clock;
  probe(clock, 0, 500, 500);
  EXPECT_EQ(clock.uncertainty_ns(), 500);
}

TEST(ClockOffset, ErrsByLessThanItsUncertaintyOverAnyOneSidedLine) {
  for (const std::int64_t there_ns : {0, 10'000, 90'000'000}) {
    for (const std::int64_t back_ns : {0, 20'000, 70'000'000}) {
      ClockOffset clock;
      probe(clock, 77, there_ns, back_ns);
      EXPECT_LE(std::abs(clock.offset_ns() - kOffset_ns), clock.uncertainty_ns()) << there_ns << " " << back_ns;
    }
  }
}

TEST(ClockOffset, IsGoodToTwoMillisecondsOverJitterOfTwentyFive) {  // protocol.md: 200 ms round trip, +-25 ms
  std::mt19937_64 random(1);
  std::uniform_int_distribution<std::int64_t> way_ns(87'500'000, 112'500'000);
  ClockOffset clock;
  for (std::uint64_t i = 0; i < ClockOffset::kWindow; ++i) {
    const std::int64_t there_ns = way_ns(random);
    probe(clock, i * 50'000'000, there_ns, way_ns(random));
  }
  EXPECT_LE(std::abs(clock.offset_ns() - kOffset_ns), 2'000'000);
}

TEST(ClockOffset, IsGoodToTenMillisecondsWhereMostRepliesWaitBehindOtherBytes) {
  std::mt19937_64 random(1);
  std::uniform_int_distribution<std::int64_t> way_ns(75'000'000, 125'000'000), wait_ns(0, 600'000'000);
  ClockOffset clock;
  for (std::uint64_t i = 0; i < ClockOffset::kWindow; ++i) {
    const std::int64_t queued_ns = i % 4 == 0 ? 0 : wait_ns(random);
    const std::int64_t there_ns = way_ns(random);
    probe(clock, i * 50'000'000, there_ns, way_ns(random) + queued_ns);
  }
  EXPECT_LE(std::abs(clock.offset_ns() - kOffset_ns), 10'000'000);
}

TEST(ClockOffset, IsNotMovedByAFewStalls) {
  ClockOffset clock;
  for (std::uint64_t i = 0; i < 20; ++i) probe(clock, i * 50'000'000, i % 4 == 0 ? 900'000'000 : 1'000'000, 1'000'000);
  EXPECT_EQ(clock.offset_ns(), kOffset_ns);
}

TEST(ClockOffset, ForgetsWhatIsOlderThanItsWindow) {
  ClockOffset clock;
  for (std::uint64_t i = 0; i < 10; ++i) probe(clock, i, 10, 10);
  for (std::uint64_t i = 0; i < ClockOffset::kWindow; ++i) probe(clock, 100 + i, 2'000, 2'000, 2 * kOffset_ns);
  EXPECT_EQ(clock.offset_ns(), 2 * kOffset_ns);
  EXPECT_EQ(clock.uncertainty_ns(), 2'000);
}

TEST(Monotonic, NeverGoesBack) {
  std::uint64_t last = monotonicNow_ns();
  for (int i = 0; i < 1'000; ++i) {
    const std::uint64_t now = monotonicNow_ns();
    EXPECT_GE(now, last);
    last = now;
  }
}

TEST(ClockOffset, IgnoresTimesThatNoClockHas) {
  ClockOffset clock;
  clock.add(100, UINT64_MAX / 2, 1ULL << 63, 200);
  EXPECT_FALSE(clock.known());
  clock.add(100, 1150, 1150, 200);
  EXPECT_EQ(clock.offset_ns(), 1000);
  EXPECT_EQ(clock.toClient_ns(UINT64_MAX), static_cast<std::int64_t>(ClockOffset::kLatest_ns) - 1000);
}

}  // namespace
}  // namespace haptics::clock_offset_test

#include "haptic_server/device/usb/link_watch.h"

#include <gtest/gtest.h>

namespace haptics::test::link_watch_test {
namespace {

constexpr std::uint64_t kMs = 1'000'000;

/// A link at 1 kHz.
struct Link {
  LinkWatch watch{1'000 * kMs, kMs, true};
  std::uint64_t now_ns = 1'000 * kMs;

  DeviceFault tick(bool reply, bool send = true) {
    if (send) watch.sent();
    now_ns += kMs;
    watch.cycle();
    if (reply) watch.reply(now_ns);
    return watch.judge(now_ns);
  }
  DeviceFault good(int ticks) {
    DeviceFault fault = DeviceFault::kNone;
    for (int i = 0; i < ticks; ++i) fault = tick(true);
    return fault;
  }
};

TEST(LinkWatch, BelievesALinkThatRepliesEachTime) {
  Link link;
  EXPECT_EQ(link.good(10'000), DeviceFault::kNone);
}

TEST(LinkWatch, NoticesSilenceAfterThreeMilliseconds) {
  Link link;
  link.good(100);
  for (int ms = 1; ms <= 2; ++ms) EXPECT_EQ(link.tick(false), DeviceFault::kNone) << ms;
  EXPECT_EQ(link.tick(false), DeviceFault::kSilent);
}

TEST(LinkWatch, DoesNotBlameTheDeviceForADriverThatWasHeldUp) {
  Link link;
  link.good(100);
  link.now_ns += 50 * kMs;
  EXPECT_EQ(link.watch.judge(link.now_ns), DeviceFault::kNone);
  EXPECT_EQ(link.good(100), DeviceFault::kNone);
}

TEST(LinkWatch, CallsItGarbledWhenBytesComeThatAreNoReply) {
  Link link;
  link.good(100);
  for (int ms = 1; ms <= 5; ++ms) {
    link.watch.garbled(link.now_ns + 500'000);
    static_cast<void>(link.tick(false));
  }
  EXPECT_EQ(link.watch.judge(link.now_ns), DeviceFault::kGarbled);
}

TEST(LinkWatch, AReplyThatIsLostNowAndThenIsNoFault) {
  Link link;
  for (int i = 0; i < 10'000; ++i) ASSERT_EQ(link.tick(i % 300 != 0), DeviceFault::kNone) << i;
}

TEST(LinkWatch, IsWellAgainAfterEnoughGoodReplies) {
  Link link;
  link.good(100);
  for (int i = 0; i < 6; ++i) static_cast<void>(link.tick(false, false));
  EXPECT_EQ(link.good(LinkWatch::kRecovery - 1), DeviceFault::kSilent);
  EXPECT_EQ(link.good(1), DeviceFault::kNone);
}

TEST(LinkWatch, NoticesRepliesThatAllComeLate) {
  Link link;
  link.good(100);
  for (int i = 0; i < 12; ++i) static_cast<void>(link.tick(false));
  EXPECT_EQ(link.good(200), DeviceFault::kLate) << "a reply each millisecond, but to a command of 12 ms ago";
}

TEST(LinkWatch, AfterLateRepliesWaitsUntilAllAreInAndGoesOn) {
  Link link;
  link.good(100);
  for (int i = 0; i < 12; ++i) static_cast<void>(link.tick(false));
  static_cast<void>(link.good(30));
  EXPECT_TRUE(link.watch.maySend(link.now_ns, false)) << "the force has to be taken away first";
  EXPECT_FALSE(link.watch.maySend(link.now_ns, true));
  for (int i = 0; i < 12; ++i) static_cast<void>(link.tick(true, false));
  int silent = 0;
  while (!link.watch.maySend(link.now_ns, true)) {
    static_cast<void>(link.tick(false, false));
    ASSERT_LT(++silent, 30);
  }
  EXPECT_EQ(link.good(LinkWatch::kRecovery), DeviceFault::kNone);
}

TEST(LinkWatch, KeepsTheFirstCause) {
  Link link;
  link.good(100);
  link.watch.raise(DeviceFault::kStalled);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(link.tick(false, false), DeviceFault::kStalled);
}

TEST(OutputGain, FallsWithinTwentyMillisecondsAndRisesSlower) {
  OutputGain gain;
  for (int i = 0; i < 50; ++i) static_cast<void>(gain.next(false, 1e-3));
  EXPECT_NEAR(gain.next(false, 0), 1, 1e-12);
  double last = 1;
  for (int i = 0; i < 20; ++i) {
    const double now = gain.next(true, 1e-3);
    EXPECT_NEAR(now, last - 0.05, 1e-9);
    last = now;
  }
  EXPECT_NEAR(last, 0, 1e-9);
  EXPECT_EQ(gain.next(true, 1e-3), 0);
  EXPECT_NEAR(gain.next(false, 1e-3), 0.02, 1e-9);
}

}  // namespace
}  // namespace haptics::test::link_watch_test

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <thread>

#include "haptic_server/servo/flight_ring.h"

namespace haptics::flight_ring_tests {
namespace {

constexpr StepConfig kConfig;
constexpr double kRate_Hz = 100;

/// Of a ring of one hand.
using OneTick = std::array<RecordedTick, 1>;

OneTick tickOf(std::uint64_t number) {
  RecordedTick tick;
  tick.input = {number, 2 * number, {Vec3(static_cast<double>(number)), DeviceState::kReady, {}}};
  tick.scene = 3 * number;
  tick.force_N = Vec3(-static_cast<double>(number));
  return {tick};
}

void expectTick(const OneTick& ofOne, std::uint64_t number) {
  const RecordedTick& tick = ofOne[0];
  EXPECT_EQ(tick.input.tick, number);
  EXPECT_EQ(tick.input.time_ns, 2 * number);
  EXPECT_EQ(tick.input.device.position, Vec3(static_cast<double>(number)));
  EXPECT_EQ(tick.scene, 3 * number);
  EXPECT_EQ(tick.force_N, Vec3(-static_cast<double>(number)));
}

TEST(FlightRing, HoldsAtLeastTheLastTenSecondsAndKnowsWhatItHasOverwritten) {
  FlightRing ring(kRate_Hz, 1);
  constexpr std::uint64_t kTicks = 5000;
  for (std::uint64_t i = 0; i < kTicks; ++i) ring.add(tickOf(i));
  EXPECT_EQ(ring.end(), kTicks);
  OneTick tick;
  for (std::uint64_t back = 1; back <= static_cast<std::uint64_t>(FlightRing::kSeconds * kRate_Hz); ++back) {
    ASSERT_TRUE(ring.read(kTicks - back, tick)) << back;
    expectTick(tick, kTicks - back);
  }
  EXPECT_FALSE(ring.read(0, tick));
  EXPECT_FALSE(ring.read(kTicks, tick)) << "not yet";
}

TEST(FlightRing, NeverGivesATickThatIsBeingOverwritten) {
  FlightRing ring(kRate_Hz, 1);
  std::atomic<bool> stop{false};
  std::thread servo([&] {
    for (std::uint64_t i = 0; !stop; ++i) ring.add(tickOf(i));
  });
  std::uint64_t read = 0, lost = 0;
  OneTick tick;
  while (read < 20'000 || lost < 100) {
    const std::uint64_t end = ring.end();
    if (end < 1200) continue;
    const std::uint64_t oldest = end - 1200;  // about to go
    if (ring.read(oldest, tick)) {
      expectTick(tick, oldest);
      ++read;
    } else {
      ++lost;
    }
    if (ring.read(end - 1, tick)) {
      expectTick(tick, end - 1);
      ++read;
    }
  }
  stop = true;
  servo.join();
}

TEST(FlightRing, TakesAKeyframeEachSecondFromWhichAllTicksAreThere) {
  FlightRing ring(kRate_Hz, 1);
  HapticState state(kConfig);
  for (std::uint64_t i = 0; i < 2950; ++i) {
    state.adoption.fadeOut_s = static_cast<double>(i);
    ring.beginTick(std::array{StateMoment{&state, 4, 5}});
    ring.add(tickOf(i));
  }
  const FlightRing::HeldKeyframes held(ring);
  const auto keyframe = held.atOrBefore(1950);
  ASSERT_EQ(keyframe.size(), 1U);
  EXPECT_EQ(keyframe[0].position, 1900U) << "the newest before";
  EXPECT_EQ(keyframe[0].state.adoption.fadeOut_s, 1900);
  EXPECT_EQ(keyframe[0].scene, 4U);
  EXPECT_EQ(keyframe[0].pending, 5U);
  EXPECT_EQ(held.atOrBefore(0)[0].position, 1800U) << "the oldest whose ticks are there";
}

TEST(FlightRing, TakesNoKeyframeWhileTheyAreHeldAndOneAsSoonAsTheyAreNot) {
  FlightRing ring(kRate_Hz, 1);
  HapticState state(kConfig);
  const auto run = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) {
      ring.beginTick(std::array{StateMoment{&state, 0, 0}});
      ring.add(tickOf(ring.end()));
    }
  };
  run(50);
  {
    const FlightRing::HeldKeyframes held(ring);
    run(500);
    EXPECT_EQ(held.atOrBefore(550)[0].position, 0U);
  }
  run(1);
  EXPECT_EQ(FlightRing::HeldKeyframes(ring).atOrBefore(600)[0].position, 550U);
}

/// Runs a servo in another process, which is killed wherever it is, some ticks after it began.
template <class Run>
void runAndKill(const FlightRing& ring, const Run& run) {
  const pid_t servo = fork();
  if (servo == 0) run();
  while (ring.end() < 2'000) usleep(100);
  kill(servo, SIGKILL);
  ASSERT_EQ(waitpid(servo, nullptr, 0), servo);
}

TEST(FlightRing, OutlivesTheProcessThatWroteItWhereverItWasKilled) {
  for (int i = 0; i < 50; ++i) {
    FlightRing made(kRate_Hz, 1);
    runAndKill(made, [&] {
      HapticState state(kConfig);
      for (std::uint64_t number = 0;; ++number) {
        state.adoption.fadeOut_s = static_cast<double>(number);
        state.report.depenetratedFrom = number;
        made.beginTick(std::array{StateMoment{&state, 0, 0}});
        made.add(tickOf(number));
      }
    });
    auto ring = FlightRing::attach(FileHandle(dup(made.descriptor())));
    ASSERT_TRUE(ring) << ring.error().text();
    ring->releaseDeadWriter();
    const std::uint64_t end = ring->end();
    ASSERT_GE(end, 2'000U);
    const FlightRing::HeldKeyframes held(*ring);
    const auto keyframe = held.atOrBefore(end - 1000);
    ASSERT_EQ(keyframe.size(), 1U);
    EXPECT_EQ(keyframe[0].state.report.depenetratedFrom, keyframe[0].position);
    EXPECT_EQ(keyframe[0].state.adoption.fadeOut_s, static_cast<double>(keyframe[0].position));
    OneTick tick;
    for (std::uint64_t position = keyframe[0].position; position < end; ++position) {
      ASSERT_TRUE(ring->read(position, tick));
      expectTick(tick, position);
    }
  }
}

TEST(FlightRing, OfAServoThatEndedBetweenTwoTicksNothingIsLost) {
  FlightRing ring(kRate_Hz, 1);
  HapticState state(kConfig);
  for (std::uint64_t i = 0; i < 2000; ++i) {
    ring.beginTick(std::array{StateMoment{&state, 0, 0}});
    ring.add(tickOf(i));
  }
  ring.releaseDeadWriter();
  EXPECT_EQ(FlightRing::HeldKeyframes(ring).atOrBefore(1000)[0].position, 1000U);
}

TEST(FlightRing, MemoryOfSomethingElseIsRefused) {
  EXPECT_FALSE(FlightRing::attach(FileHandle()));
  auto zeros = SharedMemory::make("zeros", 100'000'000);
  ASSERT_TRUE(zeros);
  const auto ring = FlightRing::attach(FileHandle(dup(zeros->descriptor())));
  ASSERT_FALSE(ring);
  EXPECT_EQ(ring.error().text(), "flight ring: is that of another build");
}

}  // namespace
}  // namespace haptics::flight_ring_tests

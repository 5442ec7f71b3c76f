#include "haptic_server/recording/replay_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "recorded_servo.h"

namespace haptics::replay_check_test {
namespace {

using namespace test;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(ReplayCheck, FindsNoDifferenceAcrossEditsAndMissedTicks) {
  for (const int hands : {1, 2}) {
    RecordedServo servo(kScene + kBlock + kCushion, hands, true);
    const auto run = [&](int ticks) { hands == 1 ? servo.run(ticks) : servo.runBoth(ticks); };
    run(2000);
    servo.apply(R"(operations { set_material { object { name: "slab" } material { stiffness_N_per_m: 1500 } } })");
    run(2000);
    servo.skip(7);
    servo.apply(R"(operations { remove { object { name: "ball" } } })");
    run(1500);
    const ReplayCheck::Count count = servo.check();
    EXPECT_EQ(count.ticks, 5500U);
    EXPECT_EQ(count.skipped, 0U);
    EXPECT_EQ(count.differences, 0U) << count.first;
    EXPECT_GT(servo.contactTicks(), 100U);
  }
}

TEST(ReplayCheck, NamesTheFieldOfTheStateThatDiffersAndItsTick) {
  RecordedServo servo(kScene, 1, true);
  servo.run(1500);
  ++servo.state().report.depenetrated;  // without a reason that a recording has
  servo.run(1000);
  const ReplayCheck::Count count = servo.check();
  EXPECT_EQ(count.differences, 1U);
  EXPECT_THAT(count.first, AllOf(HasSubstr("report.depenetrated"), HasSubstr("before tick 2000")));
  EXPECT_THAT(servo.warnings(), HasSubstr(count.first));
  EXPECT_EQ(count.ticks, 2000U);
  EXPECT_EQ(count.skipped, 500U) << "there is no state after them from which to go on";
}

TEST(ReplayCheck, NamesTheTickWhoseForceDiffers) {
  RecordedServo servo(kScene, 1, true);
  servo.run(1500);
  servo.state().limits.slew.begin();
  servo.state().observer = {};
  servo.run(100);
  const ReplayCheck::Count count = servo.check();
  EXPECT_EQ(count.differences, 1U);
  EXPECT_THAT(count.first, HasSubstr("the first at tick 15"));
}

TEST(ReplayCheck, SkipsTicksWhereItIsBehindAndGoesOnAtALaterState) {
  RecordedServo servo(kScene, 1, true);
  std::uint64_t ticks = 0;
  const auto run = [&](std::uint64_t more) {
    servo.run(static_cast<int>(more));
    ticks += more;
    servo.recorder().collect();
  };
  const auto now = [&] { return servo.recorder().check()->count(); };
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  const auto isInTime = [&] { return std::chrono::steady_clock::now() < until; };
  while (now().skipped == 0 && isInTime()) {
    run(11'500);  // more than FlightRing::kSeconds at once
    run(400);     // where the machine holds this thread up, the check may have caught up
  }
  const std::uint64_t toCheck = ticks - now().skipped;
  while (now().ticks <= toCheck && isInTime()) {
    run(1000);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const ReplayCheck::Count count = servo.check();
  EXPECT_GT(count.ticks, toCheck);
  EXPECT_GT(count.skipped, 0U);
  EXPECT_EQ(count.ticks + count.skipped, ticks);
  EXPECT_EQ(count.differences, 0U) << count.first;
  EXPECT_THAT(servo.warnings(), HasSubstr("cannot keep up"));
}

}  // namespace
}  // namespace haptics::replay_check_test

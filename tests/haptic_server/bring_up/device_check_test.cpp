#include "haptic_server/bring_up/device_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/haptic_server/device/emulated/defective_arm.h"

namespace haptics::device_check_test {
namespace {

using test::Defect;
using test::DefectiveArm;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr unsigned kTimes = 20;
constexpr double kMoves_s = 1.5;

/// Passes as fast as it is asked for.
class VirtualTime final : public CheckTime {
 public:
  [[nodiscard]] std::uint64_t now_ns() override { return now_ns_; }
  void sleepUntil(std::uint64_t time_ns) override {
    now_ns_ = std::max(now_ns_, time_ns) + std::exchange(pause_ns_, 0);
  }
  [[nodiscard]] bool pauseProcess(double seconds) override {
    pause_ns_ = static_cast<std::uint64_t>(seconds * 1e9);
    return true;
  }

 private:
  std::uint64_t now_ns_ = 1'000'000'000, pause_ns_ = 0;
};

class Arm final : public Device {
 public:
  Arm(DefectiveArm& arm, CheckTime& time) : arm_(arm), time_(time) {
    info_ = {.name = "arm",
             .maxForce_N = DefectiveArm::kMaxForce_N,
             .maxStiffness_N_per_m = arm.saidStiffness_N_per_m(),
             .resolution_m = DefectiveArm::kResolution_m,
             .delay_s = DefectiveArm::kDelay_s};
  }
  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] bool hasNewSample() noexcept override { return arm_.read(time_.now_ns()).count != read_; }
  [[nodiscard]] DeviceReading read(std::uint64_t /*tick*/) noexcept override {
    const auto& newest = arm_.read(time_.now_ns());
    read_ = newest.count;
    DeviceReading reading;
    reading.position = newest.position;
    reading.state = DeviceState::kReady;
    reading.status.age_us = static_cast<std::uint32_t>((time_.now_ns() - newest.measured_ns) / 1'000);
    return reading;
  }
  void write(Vec3 force_N) noexcept override { arm_.write(stopped_ ? Vec3(0) : force_N, time_.now_ns()); }
  void stop() noexcept override { stopped_ = true; }

 private:
  DefectiveArm& arm_;
  CheckTime& time_;
  DeviceInfo info_;
  std::uint64_t read_ = 0;
  bool stopped_ = false;
};

struct Outcome {
  bool good = false;
  std::string said;
};

[[nodiscard]] Outcome check(Defect defect, unsigned seed) {
  VirtualTime time;
  DefectiveArm arm(defect, seed, kMoves_s);
  Arm device(arm, time);
  Outcome outcome;
  DeviceCheck check(device, time, 1000, [&](const std::string& line) { outcome.said += line + '\n'; });
  EXPECT_TRUE(check.waitUntilReady());
  check.readPositions(kMoves_s + 0.5);
  check.judgeForces(1);
  check.judgeAxes();
  outcome.good = check.good();
  return outcome;
}

TEST(DeviceCheck, PassesASoundDeviceInManyHands) {
  for (unsigned seed = 0; seed < kTimes; ++seed) {
    const Outcome outcome = check(Defect::kNone, seed);
    EXPECT_TRUE(outcome.good) << "seed " << seed << '\n' << outcome.said;
    EXPECT_THAT(outcome.said, Not(HasSubstr("BAD")));
  }
}

class DeviceCheckOf : public testing::TestWithParam<std::pair<Defect, const char*>> {};

TEST_P(DeviceCheckOf, FailsAndSaysWhy) {
  const auto [defect, finding] = GetParam();
  for (unsigned seed = 0; seed < kTimes; ++seed) {
    const Outcome outcome = check(defect, seed);
    EXPECT_FALSE(outcome.good) << "seed " << seed;
    EXPECT_THAT(outcome.said, HasSubstr(std::string("BAD   ") + finding)) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Defects, DeviceCheckOf,
    testing::Values(
        std::pair{Defect::kXStandsStill, "x never changed"}, std::pair{Defect::kAllStandStill, "z never changed"},
        std::pair{Defect::kValuesAt60Hz, "x has a new value only with every 17th position"},
        std::pair{Defect::kPositionsAt60Hz, "new positions are 17.0 ms apart"},
        std::pair{Defect::kPositionsAt500Hz, "new positions are 2.0 ms apart"},
        std::pair{Defect::kSpikes, "positions jump"}, std::pair{Defect::kJump, "positions jump, 2 times"},
        std::pair{Defect::kNoise, "x is noisy"}, std::pair{Defect::kOldPositions, "positions are fresh enough"},
        std::pair{Defect::kReversedZ, "+z pushes the other way"}, std::pair{Defect::kXForY, "+x pushes along y"},
        std::pair{Defect::kNoForce, "+x does not move the hand"}, std::pair{Defect::kLateForce, "forces are in time"},
        std::pair{Defect::kNoWatchdog, "the force stays while this program stands still"},
        std::pair{Defect::kSlowWatchdog, "the device takes its force away by itself"},
        std::pair{Defect::kStifferSaidThanBorne, "a spring is steady"},
        std::pair{Defect::kForceEndsSlowly, "the force ends within 30 ms"}),
    [](const auto& one) { return std::string(test::kDefects[static_cast<std::size_t>(one.param.first)]); });

}  // namespace
}  // namespace haptics::device_check_test

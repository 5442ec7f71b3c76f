#include <gmock/gmock.h>

#include <map>

#include "tests/haptic_server/device/usb/virtual_rig.h"

namespace haptics::test::virtual_faults_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

struct Injection {
  EmulatedFault fault;
  bool unplug;
  DeviceFault cause;
};

/// Injects a fault 100 times, at another moment of the millisecond and of the stroke each time, while the hand is pressed.
template <class Model>
class Injector {
 public:
  static constexpr int kTimes = 100;

  explicit Injector(Injection injection) : injection_(injection) {}

  void run() {
    const bool done = rig_.until([this] { return pass(); }, 1200);
    EXPECT_TRUE(done) << "recovered " << injected_ << " times; " << ::testing::PrintToString(rig_.log.back());
    EXPECT_LE(worstDetected_ns_, 5 * kMs);
    EXPECT_LE(worstZero_ns_, 30 * kMs);
    EXPECT_EQ(causes_[injection_.cause], kTimes) << ::testing::PrintToString(causes_);
    EXPECT_THAT(rig_.log, Contains(HasSubstr(inWords(injection_.cause))));
    ::testing::Test::RecordProperty("worst_detected_us", static_cast<int>(worstDetected_ns_ / 1000));
    ::testing::Test::RecordProperty("worst_zero_us", static_cast<int>(worstZero_ns_ / 1000));
  }

 private:
  /// One look at the rig; true once the device has recovered from the last injection.
  bool pass() {
    switch (stage_) {
      case Stage::kWaiting:
        waitForAMoment();
        return false;
      case Stage::kFaulty:
        watchFault();
        return false;
      case Stage::kRecovering:
        if (rig_.feeling()) stage_ = Stage::kWaiting;
        return injected_ == kTimes && stage_ == Stage::kWaiting;
    }
    return false;
  }

  void waitForAMoment() {
    const std::uint64_t now_ns = rig_.bus.now_ns;
    if (at_ns_ == 0 && rig_.pressing()) at_ns_ = now_ns + static_cast<std::uint64_t>(tenths_(random_)) * kMs / 10;
    if (at_ns_ == 0 || now_ns < at_ns_) return;
    if (!rig_.pressing()) {
      at_ns_ = 0;
      return;
    }
    inject(true);
    at_ns_ = now_ns;
    detected_ns_ = zero_ns_ = 0;
    ++injected_;
    stage_ = Stage::kFaulty;
  }

  void watchFault() {
    const std::uint64_t now_ns = rig_.bus.now_ns;
    if (detected_ns_ == 0 && rig_.sample.fault != Fault::kNone) detected_ns_ = now_ns;
    // Behind a plug that was pulled there are no motors: there the servo's force is judged.
    const bool off = injection_.unplug ? rig_.sample.force.written == Vec3(0) : !rig_.model.motorsOn();
    if (zero_ns_ == 0 && off) zero_ns_ = now_ns;
    if (zero_ns_ != 0 && !off) zero_ns_ = 0;
    if (now_ns < at_ns_ + 80 * kMs) return;
    EXPECT_NE(detected_ns_, 0U);
    EXPECT_NE(zero_ns_, 0U);
    worstDetected_ns_ = std::max(worstDetected_ns_, detected_ns_ - at_ns_);
    worstZero_ns_ = std::max(worstZero_ns_, zero_ns_ - at_ns_);
    ++causes_[rig_.sample.device.fault];
    inject(false);
    stage_ = Stage::kRecovering;
    at_ns_ = 0;
  }

  void inject(bool on) {
    if (injection_.unplug) {
      if (!on) rig_.model.powerCycle();
      rig_.bus.plugged[0].present = !on;
    } else {
      rig_.model.setFault(on ? injection_.fault : EmulatedFault::kNone, rig_.bus.now_ns);
    }
  }

  enum class Stage { kWaiting, kFaulty, kRecovering };

  Injection injection_;
  Rig<Model> rig_;
  std::mt19937 random_{17};
  std::uniform_int_distribution<int> tenths_{0, 999};
  Stage stage_ = Stage::kWaiting;
  int injected_ = 0;
  std::uint64_t at_ns_ = 0, detected_ns_ = 0, zero_ns_ = 0, worstDetected_ns_ = 0, worstZero_ns_ = 0;
  std::map<DeviceFault, int> causes_;
};

template <class Model>
void injectOften(Injection injection) {
  Injector<Model>(injection).run();
}

template <class Model>
class VirtualFaults : public ::testing::Test {};
TYPED_TEST_SUITE(VirtualFaults, Models, ModelNames);

TYPED_TEST(VirtualFaults, ShortPacketsAHundredTimes) {
  injectOften<TypeParam>({EmulatedFault::kShort, false, DeviceFault::kGarbled});
}
TYPED_TEST(VirtualFaults, ShiftedPacketsAHundredTimes) {
  // Reports of 8 bytes without a frame show it by where they would put the hand.
  const bool framed = std::is_same_v<TypeParam, FalconModel>;
  injectOften<TypeParam>({EmulatedFault::kShifted, false, framed ? DeviceFault::kGarbled : DeviceFault::kJumped});
}
TYPED_TEST(VirtualFaults, SilenceAHundredTimes) {
  injectOften<TypeParam>({EmulatedFault::kSilence, false, DeviceFault::kSilent});
}
TYPED_TEST(VirtualFaults, StallsAHundredTimes) {
  injectOften<TypeParam>({EmulatedFault::kStall, false, DeviceFault::kStalled});
}
TYPED_TEST(VirtualFaults, SlowRepliesAHundredTimes) {
  const bool asked = std::is_same_v<TypeParam, FalconModel>;
  injectOften<TypeParam>({EmulatedFault::kSlow, false, asked ? DeviceFault::kLate : DeviceFault::kSilent});
}
TYPED_TEST(VirtualFaults, JumpsAHundredTimes) {
  injectOften<TypeParam>({EmulatedFault::kJump, false, DeviceFault::kJumped});
}
TYPED_TEST(VirtualFaults, GlitchesOfMillimetresAHundredTimes) {
  injectOften<TypeParam>({EmulatedFault::kGlitch, false, DeviceFault::kJumped});
}
TYPED_TEST(VirtualFaults, UnplugsAHundredTimes) { injectOften<TypeParam>({{}, true, DeviceFault::kUnplugged}); }

TEST(VirtualFalcon, LosesItsHomingAHundredTimes) {
  injectOften<FalconModel>({EmulatedFault::kUnhomed, false, DeviceFault::kHomingLost});
}
TEST(VirtualFalcon, FirmwareThatArrivesDamagedIsNamedAndTriedAgainAHundredTimes) {
  for (int i = 0; i < 100; ++i) {
    Rig<FalconModel> rig;
    rig.model.setFault(EmulatedFault::kFirmware, 0);
    bool named = false, force = false;
    ASSERT_TRUE(rig.until([&] {
      named = named || rig.sample.device.fault == DeviceFault::kFirmware;
      force = force || rig.model.motorsOn();
      if (named) rig.model.setFault(EmulatedFault::kNone, 0);
      return named && rig.sample.deviceState == DeviceState::kHoming;
    }));
    EXPECT_FALSE(force);
    EXPECT_THAT(rig.log, Contains(HasSubstr("echo differs at byte 300")));
  }
}

}  // namespace
}  // namespace haptics::test::virtual_faults_test

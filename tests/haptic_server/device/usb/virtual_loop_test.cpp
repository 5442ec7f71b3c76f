#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "common/mesh/generators.h"
#include "haptic_server/device/usb/falcon.h"
#include "haptic_server/device/usb/usb_device.h"
#include "haptic_server/device/usb/wooden_haptics.h"
#include "haptic_server/servo/haptic_step.h"
#include "haptic_server/servo/news_patience.h"
#include "tests/haptic_server/device/emulated/falcon_model.h"
#include "tests/haptic_server/device/emulated/wooden_model.h"
#include "tests/haptic_server/device/usb/some_firmware.h"
#include "tests/haptic_server/device/usb/virtual_usb.h"

// Driver, servo step and emulated device with its hand in closed loop, in virtual time: every timing is exact.
namespace haptics::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr std::uint64_t kMs = 1'000'000;

std::unique_ptr<UsbProtocol> protocolFor(const FalconModel&, std::optional<FalconFirmware> firmware) {
  return std::make_unique<Falcon>(DeviceCalibration{}, std::move(firmware));
}
std::unique_ptr<UsbProtocol> protocolFor(const WoodenModel&, const std::optional<FalconFirmware>&) {
  return std::make_unique<WoodenHaptics>(DeviceCalibration{});
}

/// A server's device and servo threads on one time line, with a plate of 0.2 m under the middle of the workspace.
template <class Model>
class Rig {
 public:
  explicit Rig(std::optional<FalconFirmware> firmware = someFirmware()) {
    bus.plugged.push_back({{1, 2, "1-1", "SIM00001"}, &model});
    device.emplace(bus, protocolFor(model, std::move(firmware)),
                   UsbDeviceSettings{.wanted = "",
                                     .info = [this](const std::string& line) { log.push_back(line); },
                                     .warning = [this](const std::string& line) { log.push_back(line); }});
    config.maxForce_N = device->info().maxForce_N;
    state.emplace(config);
    const TriMesh plate = makeBox(Vec3(0.2, 0.2, 0.1), 2).value();
    scene.objects.push_back(
        {1, buildSurface(plate.vertices, plate.triangles), Pose{Quat(1, 0, 0, 0), Vec3(0, 0, -0.01)}, 800, 0.5, false});
    adopted = adoptScene(scene, *state, 0);
    bus.nextTime_ns = servoDue_ns_ = servoWakes_ns_ = bus.now_ns;
    bus.onTime = [this](std::uint64_t now_ns) { return pass(now_ns); };
  }

  /// Runs until `done`, which is asked each 0.1 ms; false when it never was in `limit_s` seconds.
  bool until(std::function<bool()> done, double limit_s = 20) {
    done_ = std::move(done);
    quit_ = ok_ = false;
    deadline_ns_ = bus.now_ns + static_cast<std::uint64_t>(limit_s * 1e9);
    device->drive(quit_);
    return ok_;
  }
  bool feeling() const { return sample.fault == Fault::kNone && sample.deviceState == DeviceState::kReady; }
  bool pressing() const { return feeling() && glm::length(sample.force.written) > 0.3 && model.motorsOn(); }

  VirtualUsb bus;
  Model model;
  std::vector<std::string> log;
  std::optional<UsbDevice> device;
  StepConfig config{.period_s = 1e-3};
  std::optional<HapticState> state;
  ServoScene scene;
  bool adopted = false;
  TelemetrySample sample;
  std::uint64_t tick = 0;
  bool servoAlive = true;
  /// Wakes up so much later than it should, at most: another time in each tick.
  std::uint64_t servoJitter_ns = 0;
  /// The servo's beat, later by so much from now on.
  void delayServo(std::uint64_t by_ns) { servoDue_ns_ += by_ns; }
  bool motorsWereOn = false;  ///< At the last instant before `until` returned, which switches them off.

 private:
  std::uint64_t pass(std::uint64_t now_ns) {
    model.advance(now_ns);
    motorsWereOn = model.motorsOn();
    if (now_ns >= servoWakes_ns_) servoWakes(now_ns);
    if (now_ns >= asks_ns_) {
      if (!quit_ && done_ && done_()) quit_ = ok_ = true;
      if (now_ns > deadline_ns_) quit_ = true;
      asks_ns_ = now_ns - now_ns % (kMs / 10) + kMs / 10;
    }
    return std::min(asks_ns_, servoWakes_ns_);
  }

  /// As ServoLoop::run().
  void servoWakes(std::uint64_t now_ns) {
    if (patience_.waits(device->hasNews(), now_ns - std::min(now_ns, servoDue_ns_))) {
      servoWakes_ns_ = now_ns + patience_.step_ns();
      return;
    }
    if (servoAlive) {
      sample = hapticStep(scene, *state, config, {tick, now_ns, device->read(tick)});
      ++tick;
      device->write(sample.force.written);
    }
    servoDue_ns_ += kMs;
    servoWakes_ns_ = servoDue_ns_;
    if (servoJitter_ns > 0) servoWakes_ns_ += random_() % servoJitter_ns;
  }

  NewsPatience patience_{kMs};
  std::mt19937 random_{7};
  std::uint64_t servoDue_ns_ = 0, servoWakes_ns_ = 0, asks_ns_ = 0;

  std::function<bool()> done_;
  std::atomic<bool> quit_{false};
  bool ok_ = false;
  std::uint64_t deadline_ns_ = 0;
};

template <class Model>
class VirtualLoop : public ::testing::Test {};
using Models = ::testing::Types<FalconModel, WoodenModel>;
struct ModelNames {
  template <class Model>
  static std::string GetName(int) {
    return std::is_same_v<Model, FalconModel> ? "Falcon" : "WoodenHaptics";
  }
};
TYPED_TEST_SUITE(VirtualLoop, Models, ModelNames);

TYPED_TEST(VirtualLoop, IsBroughtUpHomedAndFelt) {
  Rig<TypeParam> rig;
  bool forceBeforeHoming = false;
  ASSERT_TRUE(rig.until([&] {
    forceBeforeHoming = forceBeforeHoming || (rig.model.motorsOn() && !rig.sample.device.homed);
    return rig.pressing();
  })) << ::testing::PrintToString(rig.log);
  EXPECT_FALSE(forceBeforeHoming);
  EXPECT_THAT(rig.log, Contains(HasSubstr("homing: ")));
  EXPECT_THAT(rig.log, Contains(HasSubstr("is homed")));
}

TYPED_TEST(VirtualLoop, UsesEveryReplyOfAMinuteAndPushesTheHandOut) {
  Rig<TypeParam> rig;
  std::uint64_t began = 0, used = 0, replies = 0, pressed = 0, wrong = 0;
  ASSERT_TRUE(rig.until(
      [&] {
        const UsbDeviceCounters& counters = rig.device->counters();
        if (began == 0 && rig.feeling()) {
          began = rig.bus.now_ns;
          used = counters.used;
          replies = counters.replies;
        }
        if (rig.pressing()) {
          ++pressed;
          if (rig.model.motorForce_N().z < 0) ++wrong;
        }
        return began != 0 && rig.bus.now_ns > began + 60'000 * kMs;
      },
      90));
  const UsbDeviceCounters& counters = rig.device->counters();
  replies = counters.replies - replies;
  used = counters.used - used;
  EXPECT_GT(replies, 59'900U);
  EXPECT_GE(static_cast<double>(used), 0.999 * static_cast<double>(replies));
  EXPECT_GT(pressed, 50'000U) << "tenths of milliseconds in contact";
  EXPECT_LT(static_cast<double>(wrong), 0.01 * static_cast<double>(pressed)) << "the plate pushes up";
  EXPECT_EQ(counters.faults, 0U);
}

TYPED_TEST(VirtualLoop, UsesEveryReplyAlsoOfOneThatComesJustWhenTheServoWakesUp) {
  Rig<TypeParam> rig;
  rig.servoJitter_ns = 60'000;
  std::uint64_t began_ns = 0, used = 0, replies = 0;
  ASSERT_TRUE(rig.until([&] {
    const UsbDeviceCounters& counters = rig.device->counters();
    if (began_ns == 0 && rig.feeling()) {
      rig.delayServo(kMs - 1'000ULL * rig.sample.device.age_us % kMs);
      began_ns = rig.bus.now_ns + 100 * kMs;
    }
    if (began_ns != 0 && rig.bus.now_ns < began_ns) {
      used = counters.used;
      replies = counters.replies;
    }
    return began_ns != 0 && rig.bus.now_ns > began_ns + 10'000 * kMs;
  }));
  const UsbDeviceCounters& counters = rig.device->counters();
  EXPECT_GT(counters.replies - replies, 9'900U);
  EXPECT_GE(static_cast<double>(counters.used - used), 0.999 * static_cast<double>(counters.replies - replies));
}

TYPED_TEST(VirtualLoop, SwitchesTheMotorsOffWhenItStops) {
  Rig<TypeParam> rig;
  ASSERT_TRUE(rig.until([&] { return rig.pressing(); }));
  EXPECT_FALSE(rig.model.motorsOn()) << "drive() has returned";
}

TYPED_TEST(VirtualLoop, AfterStopTheMotorsGoOffWhileTheDriverRuns) {
  Rig<TypeParam> rig;
  std::uint64_t stopped_ns = 0;
  ASSERT_TRUE(rig.until([&] {
    if (stopped_ns == 0 && rig.pressing()) {
      rig.device->stop();
      stopped_ns = rig.bus.now_ns;
    }
    return stopped_ns != 0 && rig.bus.now_ns > stopped_ns + 3 * kMs;
  }));
  EXPECT_EQ(rig.sample.deviceState, DeviceState::kStopped);
  EXPECT_FALSE(rig.model.motorsOn());
}

TYPED_TEST(VirtualLoop, TakesTheForceAwayWhenTheServoDies) {
  Rig<TypeParam> rig;
  std::uint64_t died_ns = 0;
  ASSERT_TRUE(rig.until([&] {
    if (died_ns == 0 && rig.pressing()) {
      died_ns = rig.bus.now_ns;
      rig.servoAlive = false;
    }
    return died_ns != 0 && rig.bus.now_ns > died_ns + 50 * kMs;
  }));
  EXPECT_FALSE(rig.motorsWereOn);
}

struct Injection {
  EmulatedFault fault;
  bool unplug;
  DeviceFault cause;
};

/// Injects a fault 100 times, at another moment of the millisecond and of the stroke each time, while the hand is pressed.
template <class Model>
void injectOften(Injection injection) {
  Rig<Model> rig;
  std::mt19937 random(17);
  std::uniform_int_distribution<int> tenths(0, 999);
  constexpr int kTimes = 100;
  enum class Stage { kWaiting, kFaulty, kRecovering } stage = Stage::kWaiting;
  int injected = 0;
  std::uint64_t at_ns = 0, detected_ns = 0, zero_ns = 0, worstDetected_ns = 0, worstZero_ns = 0;
  std::map<DeviceFault, int> causes;
  const auto inject = [&](bool on) {
    if (injection.unplug) {
      if (!on) rig.model.powerCycle();
      rig.bus.plugged[0].present = !on;
    } else {
      rig.model.setFault(on ? injection.fault : EmulatedFault::kNone, rig.bus.now_ns);
    }
  };
  const bool done = rig.until(
      [&] {
        const std::uint64_t now_ns = rig.bus.now_ns;
        switch (stage) {
          case Stage::kWaiting:
            if (at_ns == 0 && rig.pressing()) at_ns = now_ns + static_cast<std::uint64_t>(tenths(random)) * kMs / 10;
            if (at_ns == 0 || now_ns < at_ns) return false;
            if (!rig.pressing()) {
              at_ns = 0;
              return false;
            }
            inject(true);
            at_ns = now_ns;
            detected_ns = zero_ns = 0;
            ++injected;
            stage = Stage::kFaulty;
            return false;
          case Stage::kFaulty: {
            if (detected_ns == 0 && rig.sample.fault != Fault::kNone) detected_ns = now_ns;
            // Behind a plug that was pulled there are no motors: there the servo's force is judged.
            const bool off = injection.unplug ? rig.sample.force.written == Vec3(0) : !rig.model.motorsOn();
            if (zero_ns == 0 && off) zero_ns = now_ns;
            if (zero_ns != 0 && !off) zero_ns = 0;
            if (now_ns < at_ns + 80 * kMs) return false;
            EXPECT_NE(detected_ns, 0U);
            EXPECT_NE(zero_ns, 0U);
            worstDetected_ns = std::max(worstDetected_ns, detected_ns - at_ns);
            worstZero_ns = std::max(worstZero_ns, zero_ns - at_ns);
            ++causes[rig.sample.device.fault];
            inject(false);
            stage = Stage::kRecovering;
            at_ns = 0;
            return false;
          }
          case Stage::kRecovering:
            if (rig.feeling()) stage = Stage::kWaiting;
            return injected == kTimes && stage == Stage::kWaiting;
        }
        return false;
      },
      1200);
  EXPECT_TRUE(done) << "recovered " << injected << " times; " << ::testing::PrintToString(rig.log.back());
  EXPECT_LE(worstDetected_ns, 5 * kMs);
  EXPECT_LE(worstZero_ns, 30 * kMs);
  EXPECT_EQ(causes[injection.cause], kTimes) << ::testing::PrintToString(causes);
  EXPECT_THAT(rig.log, Contains(HasSubstr(inWords(injection.cause))));
  ::testing::Test::RecordProperty("worst_detected_us", static_cast<int>(worstDetected_ns / 1000));
  ::testing::Test::RecordProperty("worst_zero_us", static_cast<int>(worstZero_ns / 1000));
}

TYPED_TEST(VirtualLoop, ShortPacketsAHundredTimes) {
  injectOften<TypeParam>({EmulatedFault::kShort, false, DeviceFault::kGarbled});
}
TYPED_TEST(VirtualLoop, ShiftedPacketsAHundredTimes) {
  // Reports of 8 bytes without a frame show it by where they would put the hand.
  const bool framed = std::is_same_v<TypeParam, FalconModel>;
  injectOften<TypeParam>({EmulatedFault::kShifted, false, framed ? DeviceFault::kGarbled : DeviceFault::kJumped});
}
TYPED_TEST(VirtualLoop, SilenceAHundredTimes) {
  injectOften<TypeParam>({EmulatedFault::kSilence, false, DeviceFault::kSilent});
}
TYPED_TEST(VirtualLoop, StallsAHundredTimes) {
  injectOften<TypeParam>({EmulatedFault::kStall, false, DeviceFault::kStalled});
}
TYPED_TEST(VirtualLoop, SlowRepliesAHundredTimes) {
  const bool asked = std::is_same_v<TypeParam, FalconModel>;
  injectOften<TypeParam>({EmulatedFault::kSlow, false, asked ? DeviceFault::kLate : DeviceFault::kSilent});
}
TYPED_TEST(VirtualLoop, JumpsAHundredTimes) {
  injectOften<TypeParam>({EmulatedFault::kJump, false, DeviceFault::kJumped});
}
TYPED_TEST(VirtualLoop, UnplugsAHundredTimes) { injectOften<TypeParam>({{}, true, DeviceFault::kUnplugged}); }

TEST(VirtualFalcon, LosesItsHomingAHundredTimes) {
  injectOften<FalconModel>({EmulatedFault::kUnhomed, false, DeviceFault::kHomingLost});
}

TEST(VirtualFalcon, ABitThatSaysHomedNowAndThenDoesNotMakeItHomed) {
  Rig<FalconModel> rig;
  int homedReplies = 0;
  ASSERT_TRUE(rig.until([&] {
    rig.model.setHomedBits(homedReplies++ % 300 < 200);  // tenths of milliseconds: 20 replies of 30
    return rig.bus.now_ns > 3'000 * kMs;
  }));
  EXPECT_EQ(rig.sample.deviceState, DeviceState::kHoming);
  EXPECT_FALSE(rig.model.motorsOn());
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

TEST(VirtualFalcon, WithoutFirmwareSaysWhichOptionNamesIt) {
  Rig<FalconModel> rig(std::nullopt);
  ASSERT_TRUE(rig.until([&] { return rig.sample.device.fault == DeviceFault::kFirmware; }));
  EXPECT_THAT(rig.log, Contains(HasSubstr("--firmware FILE")));
}

TEST(VirtualFalcon, OneThatAlreadyRunsNeedsNoFirmware) {
  Rig<FalconModel> rig;
  ASSERT_TRUE(rig.until([&] { return rig.feeling(); }));
  const std::size_t loaded = rig.model.firmwareBytes();
  ASSERT_TRUE(rig.until([&] { return rig.feeling() && rig.device->counters().connections == 2; }));
  EXPECT_EQ(rig.model.firmwareBytes(), loaded);
}

TEST(VirtualFalcon, ButtonsReachTheServo) {
  Rig<FalconModel> rig;
  rig.model.press(0b1010);
  ASSERT_TRUE(rig.until([&] { return rig.feeling(); }));
  EXPECT_EQ(rig.sample.device.buttons, 0b1010);
}

TEST(VirtualFalcon, AJumpThatStaysMakesTheUserHomeItAnew) {
  Rig<FalconModel> rig;
  bool jumped = false;
  int homings = 0;
  ASSERT_TRUE(rig.until([&] {
    if (!jumped && rig.feeling()) {
      rig.model.setFault(EmulatedFault::kJump, 0);
      jumped = true;
    }
    homings = static_cast<int>(std::ranges::count_if(
        rig.log, [](const std::string& line) { return line.find("is homed") != std::string::npos; }));
    return jumped && homings == 2 && rig.feeling();
  }));
  EXPECT_EQ(rig.device->counters().connections, 2U);
}

TEST(VirtualUsbDevice, SaysWhyItIsNotThere) {
  for (const auto& [present, permitted, several, cause] : {std::tuple{false, true, false, DeviceFault::kNotFound},
                                                           std::tuple{true, false, false, DeviceFault::kNotPermitted},
                                                           std::tuple{true, true, true, DeviceFault::kAmbiguous}}) {
    Rig<FalconModel> rig;
    rig.bus.plugged[0].present = present;
    rig.bus.plugged[0].permitted = permitted;
    if (several) rig.bus.plugged.push_back({{1, 3, "1-2", ""}, &rig.model});
    ASSERT_TRUE(rig.until([&] { return rig.sample.device.fault == cause && rig.tick > 2'000; }));
    EXPECT_EQ(rig.sample.fault, Fault::kDeviceLost);
    EXPECT_EQ(rig.log.size(), 1U) << "said once: " << ::testing::PrintToString(rig.log);
  }
}

}  // namespace
}  // namespace haptics::test

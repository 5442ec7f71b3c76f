#include <gmock/gmock.h>

#include "tests/haptic_server/device/usb/virtual_rig.h"

namespace haptics::test::virtual_loop_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

template <class Model>
class VirtualLoop : public ::testing::Test {};
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
}  // namespace haptics::test::virtual_loop_test

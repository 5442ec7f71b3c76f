#include "haptic_server/device/usb/last_word.h"

#include <gmock/gmock.h>

#include "tests/haptic_server/device/usb/virtual_rig.h"

namespace haptics::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

/// A watchdog that a test lets speak.
class SpokenByHand final : public LastWord {
 public:
  void hold(int, std::uint8_t out, std::span<const std::uint8_t> zero) noexcept override {
    held = true;
    endpoint = out;
    bytes.assign(zero.begin(), zero.end());
  }
  void letGo() noexcept override { held = false; }
  [[nodiscard]] std::uint64_t spoken() const noexcept override { return times; }

  std::uint64_t times = 0;
  bool held = false;
  std::uint8_t endpoint = 0;
  std::vector<std::uint8_t> bytes;
};

template <class Model>
class LastWordOf : public ::testing::Test {};
TYPED_TEST_SUITE(LastWordOf, Models, ModelNames);

TYPED_TEST(LastWordOf, TheDriverSendsNoForceAnyMoreUntilTheServoHasFoundTheFaultAndRises) {
  SpokenByHand word;
  Rig<TypeParam> rig;
  rig.config.rise_s = 0.5;
  rig.device->give(word);
  std::uint64_t spoke_ns = 0, back_ns = 0, pushed = 0;
  bool named = false;
  double largest_N = 0;
  ASSERT_TRUE(rig.until(
      [&] {
        if (spoke_ns == 0) {
          if (!rig.pressing()) return false;
          EXPECT_TRUE(word.held);
          rig.servoAlive = false;  // it stands still, its last force in the driver's mailbox
          word.times = 1;
          spoke_ns = rig.bus.now_ns;
          return false;
        }
        if (rig.bus.now_ns < spoke_ns + 1'100 * kMs) {  // longer than a device with a fault is borne
          if (rig.bus.now_ns > spoke_ns + 2 * kMs) pushed += rig.model.motorsOn();
          return false;
        }
        if (back_ns == 0) back_ns = rig.bus.now_ns;
        rig.servoAlive = true;
        named = named || (rig.sample.fault == Fault::kDeviceLost && rig.sample.device.fault == DeviceFault::kWatchdog);
        if (rig.bus.now_ns < back_ns + 20 * kMs) {
          largest_N = std::max(largest_N, glm::length(rig.model.motorForce_N()));
          return false;
        }
        return rig.pressing();
      },
      40))
      << ::testing::PrintToString(rig.log);
  EXPECT_EQ(pushed, 0U) << "the servo stood still";
  EXPECT_EQ(largest_N, 0) << "it had not found the fault";
  EXPECT_TRUE(named);
  EXPECT_THAT(rig.log, Contains(HasSubstr("the watchdog took the force away")));
  EXPECT_EQ(rig.device->counters().connections, 1U) << "the device is well";
  EXPECT_FALSE(word.held) << "drive() has returned";
}

TYPED_TEST(LastWordOf, ItsBytesTakeTheForceAway) {
  SpokenByHand word;
  Rig<TypeParam> rig;
  rig.device->give(word);
  bool wereOn = false, areOn = true;
  ASSERT_TRUE(rig.until([&] {
    if (!rig.pressing()) return false;
    wereOn = rig.model.motorsOn();
    static_cast<void>(rig.model.out(word.bytes, rig.bus.now_ns));
    areOn = rig.model.motorsOn();
    return true;
  }));
  EXPECT_TRUE(wereOn);
  EXPECT_FALSE(areOn);
}

}  // namespace
}  // namespace haptics::test

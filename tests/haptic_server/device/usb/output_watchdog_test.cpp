#include "haptic_server/device/usb/output_watchdog.h"

#include <gmock/gmock.h>

#include "tests/haptic_server/device/usb/virtual_rig.h"

namespace haptics::test::output_watchdog_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

/// A watchdog that the test trips.
class TrippedByHand final : public OutputWatchdog {
 public:
  void arm(int, std::uint8_t out, std::span<const std::uint8_t> zero) noexcept override {
    isArmed = true;
    endpoint = out;
    bytes.assign(zero.begin(), zero.end());
  }
  void disarm() noexcept override { isArmed = false; }
  [[nodiscard]] std::uint64_t trips() const noexcept override { return times; }

  std::uint64_t times = 0;
  bool isArmed = false;
  std::uint8_t endpoint = 0;
  std::vector<std::uint8_t> bytes;
};

template <class Model>
class WatchdogOf : public ::testing::Test {};
TYPED_TEST_SUITE(WatchdogOf, Models, ModelNames);

TYPED_TEST(WatchdogOf, TheDriverSendsNoForceAnyMoreUntilTheServoHasFoundTheFaultAndRises) {
  TrippedByHand watchdog;
  Rig<TypeParam> rig;
  rig.config.rise_s = 0.5;
  rig.device->setWatchdog(watchdog);
  std::uint64_t tripped_ns = 0, back_ns = 0, pushed = 0;
  bool named = false;
  double largest_N = 0;
  ASSERT_TRUE(rig.until(
      [&] {
        if (tripped_ns == 0) {
          if (!rig.pressing()) return false;
          EXPECT_TRUE(watchdog.isArmed);
          rig.servoAlive = false;  // it stands still, its last force in the driver's mailbox
          watchdog.times = 1;
          tripped_ns = rig.bus.now_ns;
          return false;
        }
        if (rig.bus.now_ns < tripped_ns + 1'100 * kMs) {  // longer than a device with a fault is borne
          if (rig.bus.now_ns > tripped_ns + 2 * kMs) pushed += rig.model.motorsOn();
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
  EXPECT_FALSE(watchdog.isArmed) << "drive() has returned";
}

TYPED_TEST(WatchdogOf, ItsBytesTakeTheForceAway) {
  TrippedByHand watchdog;
  Rig<TypeParam> rig;
  rig.device->setWatchdog(watchdog);
  bool wereOn = false, areOn = true;
  ASSERT_TRUE(rig.until([&] {
    if (!rig.pressing()) return false;
    wereOn = rig.model.motorsOn();
    static_cast<void>(rig.model.out(watchdog.bytes, rig.bus.now_ns));
    areOn = rig.model.motorsOn();
    return true;
  }));
  EXPECT_TRUE(wereOn);
  EXPECT_FALSE(areOn);
}

}  // namespace
}  // namespace haptics::test::output_watchdog_test

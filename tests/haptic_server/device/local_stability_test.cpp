#include "haptic_server/device/local_stability.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "haptic_server/device/simulated_device.h"

namespace haptics::local_stability_test {
namespace {

constexpr double kPeriod = 1e-3;  // s

struct NoHand final : HandIntent {
  HandTarget next(double, Vec3) noexcept override { return {start, Vec3(0)}; }
  Vec3 start{0};
};

/// Peak to peak after two seconds on a spring to the origin, let go of at the disturbance (m).
double swing_m(const DevicePreset& preset, double stiffness, double disturbance_m) {
  NoHand hand;
  hand.start = Vec3(disturbance_m, 0, 0);
  SimulatedDevice device({preset, *findHandPreset("none"), kPeriod, 0}, hand);
  double least = 0, most = 0;
  for (std::uint64_t tick = 0; tick < 2000; ++tick) {
    const double x = device.read(tick).position.x;
    device.write(Vec3(-stiffness * x, 0, 0));
    if (tick >= 1800) {
      least = std::min(least, x);
      most = std::max(most, x);
    }
  }
  return most - least;
}

DeviceInfo infoOf(const DevicePreset& preset) {
  NoHand hand;
  return SimulatedDevice({preset, *findHandPreset("none"), kPeriod, 0}, hand).info();
}

TEST(LocalStability, HoldsOfEveryPresetInClosedLoop) {
  for (const DevicePreset& preset : devicePresets()) {
    const double stiffness = locallyStableStiffness_N_per_m(infoOf(preset), kPeriod);
    const double still_m = std::max(2 * preset.resolution_m, 20e-6) + 2 * preset.coulombFriction_N / stiffness;
    EXPECT_LE(swing_m(preset, 0.95 * stiffness, 0.95 * kDisturbance_m), still_m) << preset.name << ' ' << stiffness;
  }
}

TEST(LocalStability, IsLostNotFarAboveWhereTheRadiusLimitsIt) {
  const DevicePreset premium = *findDevicePreset("premium-1.5");
  const double stiffness = locallyStableStiffness_N_per_m(infoOf(premium), kPeriod);
  EXPECT_GT(swing_m(premium, 1.5 * stiffness, kDisturbance_m), 1e-3);
}

TEST(LocalStability, IsLimitedByTheEncoderStepThatFrictionHolds) {
  DeviceInfo device = infoOf(*findDevicePreset("falcon"));
  EXPECT_NEAR(locallyStableStiffness_N_per_m(device, kPeriod), 2 * 0.05 / 60e-6, 1e-3);
  device.resolution_m /= 10;
  EXPECT_GT(locallyStableStiffness_N_per_m(device, kPeriod), 2 * 0.05 / 60e-6);
}

TEST(LocalStability, AllowsMoreAtAHigherRate) {
  const DeviceInfo device = infoOf(*findDevicePreset("desktop"));
  EXPECT_GT(locallyStableStiffness_N_per_m(device, 1e-4), 2 * locallyStableStiffness_N_per_m(device, 1e-3));
}

TEST(LocalStability, IsNoLimitForADeviceOfUnknownMass) {
  EXPECT_EQ(locallyStableStiffness_N_per_m(DeviceInfo{}, kPeriod), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace haptics::local_stability_test

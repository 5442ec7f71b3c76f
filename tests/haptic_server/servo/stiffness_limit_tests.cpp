#include <gtest/gtest.h>

#include <limits>

#include "haptic_server/device/simulated_device.h"
#include "haptic_server/servo/stiffness_limit.h"

namespace haptics::stiffness_limit_tests {
namespace {

class IdleHand final : public HandIntent {
 public:
  HandTarget next(double /*dt_s*/, Vec3 /*felt_N*/) noexcept override { return {}; }
};

DeviceInfo infoOf(const DevicePreset& preset, double delay_s) {
  IdleHand idle;
  return SimulatedDevice({preset, HandPreset{}, 1e-3, delay_s}, idle).info();
}

TEST(CriticalStiffness, LeavesRoomForTwiceTheMakersStiffnessOnEveryPresetUpToAPeriodOfDelay) {
  for (const DevicePreset& preset : devicePresets()) {
    for (const double delay_s : {0.0, 1e-3}) {
      const double critical = criticalStiffness_N_per_m(infoOf(preset, delay_s), 1000, true);
      EXPECT_GT(kStabilityMargin * critical, 2 * preset.maxStiffness_N_per_m) << preset.name << ' ' << delay_s;
      EXPECT_LT(criticalStiffness_N_per_m(infoOf(preset, delay_s), 1000, false), critical / 3) << preset.name;
    }
  }
}

TEST(CriticalStiffness, IsLessWithMoreDelayAndAtALowerRate) {
  const DevicePreset& preset = devicePresets().front();
  const double critical = criticalStiffness_N_per_m(infoOf(preset, 1e-3), 1000, true);
  EXPECT_LT(criticalStiffness_N_per_m(infoOf(preset, 5e-3), 1000, true), critical / 3);
  EXPECT_LT(criticalStiffness_N_per_m(infoOf(preset, 1e-3), 500, true), critical);
}

TEST(CriticalDamping, LeavesRoomForTheMakersDampingOnEveryPresetThatIsStabilised) {
  for (const DevicePreset& preset : devicePresets()) {
    const DeviceInfo device = infoOf(preset, 1e-3);
    const double stiffest = kStabilityMargin * criticalStiffness_N_per_m(device, 1000, true);
    const double critical = criticalDamping_Ns_per_m(device, 1000, true, stiffest);
    EXPECT_GT(kStabilityMargin * critical, preset.maxDamping_Ns_per_m) << preset.name;
    EXPECT_LT(critical, 200) << preset.name;
    EXPECT_LT(criticalDamping_Ns_per_m(infoOf(preset, 5e-3), 1000, true, stiffest), critical) << preset.name;
  }
}

TEST(SurfaceLimits, AreHalfOfWhatIsCritical) {
  const DeviceInfo device = infoOf(devicePresets().front(), 2e-3);
  const SurfaceLimits limits = surfaceLimits(device, 1000, true);
  EXPECT_EQ(limits.stiffness_N_per_m, 0.5 * criticalStiffness_N_per_m(device, 1000, true));
  EXPECT_EQ(limits.damping_Ns_per_m, 0.5 * criticalDamping_Ns_per_m(device, 1000, true, limits.stiffness_N_per_m));
}

TEST(SurfaceLimits, OfTorsionAreHalfOfWhatIsCriticalWhereTheDeviceGivesTorque) {
  const DeviceInfo driven = infoOf(findDevicePreset("sigma.7").value(), 1e-3);
  const double limit_Nm_per_rad = surfaceLimits(driven, 1000, true).torsion_Nm_per_rad;
  EXPECT_EQ(limit_Nm_per_rad, 0.5 * criticalTorsion_Nm_per_rad(driven, 1000, true));
  EXPECT_GE(limit_Nm_per_rad, 1.5 * driven.rotation.maxTorsion_Nm_per_rad);
  EXPECT_LT(criticalTorsion_Nm_per_rad(driven, 1000, false), limit_Nm_per_rad)
      << "without the stabiliser it bears less";
  const DeviceInfo sensed = infoOf(findDevicePreset("omega.6").value(), 1e-3);
  EXPECT_EQ(criticalTorsion_Nm_per_rad(sensed, 1000, true), std::numeric_limits<double>::infinity());
}

TEST(SurfaceLimits, LieInNoUnstableBandBetweenTheStiffnessesThatASearchTries) {
  // At 2 kHz with half a millisecond of delay an Omni rings on some 85 kN/m, half of the largest that is tried.
  const DeviceInfo device = infoOf(findDevicePreset("omni").value(), 0.5e-3);
  const SurfaceLimits limits = surfaceLimits(device, 2000, true);
  EXPECT_LT(limits.stiffness_N_per_m, 80e3);
  EXPECT_GT(limits.damping_Ns_per_m, 0);
}

TEST(SurfaceLimits, AreNothingWhereTheSoftestWallRings) {
  const SurfaceLimits limits = surfaceLimits(infoOf(findDevicePreset("desktop").value(), 2e-3), 1000, false);
  EXPECT_EQ(limits.stiffness_N_per_m, 0);
  EXPECT_EQ(limits.damping_Ns_per_m, 0);
}

TEST(CriticalDamping, IsNotKnownOfADeviceOfUnknownMass) {
  EXPECT_EQ(criticalDamping_Ns_per_m(DeviceInfo{}, 1000, true, 1000), std::numeric_limits<double>::infinity());
}

TEST(CriticalStiffness, IsNotKnownOfADeviceOfUnknownMass) {
  EXPECT_EQ(criticalStiffness_N_per_m(DeviceInfo{}, 1000, true), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace haptics::stiffness_limit_tests

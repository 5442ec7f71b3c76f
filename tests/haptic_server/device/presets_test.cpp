#include "haptic_server/device/presets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace haptics::presets_test {
namespace {

using ::testing::HasSubstr;

TEST(DevicePresets, AreFoundByName) {
  for (const DevicePreset& preset : devicePresets()) {
    const auto found = findDevicePreset(preset.name);
    ASSERT_TRUE(found.has_value());
    EXPECT_EQ(found->title, preset.title);
  }
}

TEST(DevicePresets, HoldThePublishedFigures) {
  const DevicePreset omni = findDevicePreset("omni").value();
  EXPECT_EQ(omni.maxForce_N, 3.3);
  EXPECT_EQ(omni.maxStiffness_N_per_m, 700);
  EXPECT_EQ(omni.coulombFriction_N, 0.26);
  EXPECT_EQ(omni.resolution_m, 55e-6);
  EXPECT_EQ(findDevicePreset("omega.3")->maxForce_N, 12);
}

TEST(DevicePresets, ArePhysical) {
  for (const DevicePreset& preset : devicePresets()) {
    EXPECT_GT(preset.apparentMass_kg, 0) << preset.name;
    EXPECT_GT(preset.viscousFriction_Ns_per_m, 0) << preset.name;
    EXPECT_GT(preset.coulombFriction_N, 0) << preset.name;
    EXPECT_LT(preset.coulombFriction_N, preset.maxForce_N) << preset.name;
    EXPECT_GT(preset.resolution_m, 0) << preset.name;
    EXPECT_LT(preset.resolution_m, 1e-4) << preset.name;
  }
}

TEST(DevicePresets, AnUnknownNameIsRefusedWithTheKnownOnes) {
  const auto found = findDevicePreset("phantasm");
  ASSERT_FALSE(found.has_value());
  EXPECT_THAT(found.error().reason, HasSubstr("phantasm"));
  for (const DevicePreset& preset : devicePresets()) {
    EXPECT_THAT(found.error().reason, HasSubstr(std::string(preset.name)));
  }
}

TEST(HandPresets, TheDefaultsExistAndAnUnknownNameIsRefusedWithTheKnownOnes) {
  EXPECT_TRUE(findDevicePreset(kDefaultDevicePreset).has_value());
  EXPECT_TRUE(findHandPreset(kDefaultHandPreset).has_value());
  const auto found = findHandPreset("");
  ASSERT_FALSE(found.has_value());
  for (const HandPreset& preset : handPresets()) {
    EXPECT_THAT(found.error().reason, HasSubstr(std::string(preset.name)));
  }
}

}  // namespace
}  // namespace haptics::presets_test

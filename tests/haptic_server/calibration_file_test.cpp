#include "haptic_server/calibration_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace haptics::test::calibration_file_test {
namespace {

using ::testing::HasSubstr;

TEST(CalibrationFile, SaysWhatItSaysAndLeavesTheRestToTheDriver) {
  const auto calibration = parseCalibration(
      "world_position { x: 0.04 z: 0.06 }\nforce_scale: 0.5\nmotor_units_per_Nm: 5000\nreversed_axes: [1, 2]\n",
      "my.text");
  ASSERT_TRUE(calibration) << calibration.error().text();
  EXPECT_EQ(calibration->worldPosition, Vec3(0.04, 0, 0.06));
  EXPECT_EQ(calibration->forceScale, 0.5);
  EXPECT_EQ(calibration->motorUnitsPerNm, 5000);
  EXPECT_FALSE(calibration->workspaceScale);
  EXPECT_FALSE(calibration->maxForce_N);
  EXPECT_EQ(calibration->reversed, (std::array{false, true, true}));
}

TEST(CalibrationFile, AnUnknownKeyIsRefusedByNameWithThoseThatThereAre) {
  const auto calibration = parseCalibration("force_scale: 0.5\nforce_scael: 1\n", "my.text");
  ASSERT_FALSE(calibration);
  EXPECT_THAT(calibration.error().text(), HasSubstr("my.text:2:"));
  EXPECT_THAT(calibration.error().text(), HasSubstr("\"force_scael\""));
  EXPECT_THAT(calibration.error().text(), HasSubstr("workspace_scale"));
}

TEST(CalibrationFile, NumbersOutOfRangeAreRefusedByField) {
  for (const auto& [text, field] : {std::pair{"force_scale: 1.5", "force_scale"},
                                    {"force_scale: nan", "force_scale"},
                                    {"max_force_N: -1", "max_force_N"},
                                    {"motor_units_per_Nm: 0", "motor_units_per_Nm"},
                                    {"workspace_scale: 0", "workspace_scale"},
                                    {"turn_rad: inf", "turn_rad"},
                                    {"world_position { x: nan }", "world_position"},
                                    {"reversed_axes: 3", "reversed_axes"}}) {
    const auto calibration = parseCalibration(text, "my.text");
    ASSERT_FALSE(calibration) << text;
    EXPECT_THAT(calibration.error().text(), HasSubstr(field)) << text;
  }
}

TEST(CalibrationFile, AFileThatIsNotThereIsRefusedByName) {
  EXPECT_THAT(readCalibration("/nonexistent/calibration").error().text(), HasSubstr("/nonexistent/calibration"));
}

}  // namespace
}  // namespace haptics::test::calibration_file_test

#include "graphics_client/application/measure.h"

#include <gtest/gtest.h>

#include <vector>

namespace haptics::measure_test {
namespace {

TEST(Measure, SaysWhatToDoThenDistanceThenAngle) {
  std::vector<Vec3> places;
  EXPECT_EQ(measureText(places, std::nullopt), "measure: click a place");
  places.emplace_back(0.03, 0, 0);
  EXPECT_EQ(measureText(places, Vec3(0.001, -0.002, 0.5)), "measure: click the second place; at 1.0  -2.0  500.0 mm");
  places.emplace_back(0, 0, 0);
  EXPECT_EQ(measureText(places, std::nullopt), "distance 30.00 mm");
  places.emplace_back(-0.01, 0.01, 0);
  EXPECT_EQ(measureText(places, std::nullopt), "distance 30.00 mm, then 14.14 mm, angle 135.0\u00b0");
}

TEST(Measure, OfPlacesInOneHasNoAngleButANumber) {
  const std::vector<Vec3> places(3, Vec3(0.1));
  EXPECT_EQ(measureText(places, std::nullopt), "distance 0.00 mm, then 0.00 mm, angle 0.0\u00b0");
}

}  // namespace
}  // namespace haptics::measure_test

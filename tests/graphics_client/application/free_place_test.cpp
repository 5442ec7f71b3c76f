#include "graphics_client/application/free_place.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace haptics::free_place_test {
namespace {

/// Between two boxes, 0 where they meet.
double distance(const FloorBox& a, const FloorBox& b) {
  const glm::dvec2 apart = glm::max(glm::max(a.low - b.high, b.low - a.high), glm::dvec2(0));
  return glm::length(apart);
}

TEST(FreePlace, IsTheOriginOfAnEmptyFloor) { EXPECT_EQ(freePlace({}, {0.1, 0.1}, 0.01), glm::dvec2(0)); }

TEST(FreePlace, IsBesideAllOthersAndNotFarFromThem) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-0.3, 0.3), size(0.001, 0.2);
  std::vector<FloorBox> boxes;
  for (int i = 0; i < 200; ++i) {
    const glm::dvec2 low(place(random), place(random));
    if (i < 20) boxes.push_back({low, low + glm::dvec2(size(random), size(random))});
    const glm::dvec2 sides(size(random), size(random));
    const glm::dvec2 middle = freePlace(boxes, sides, 0.01);
    const FloorBox mine{middle - sides / 2.0, middle + sides / 2.0};
    for (const FloorBox& other : boxes) EXPECT_GE(distance(mine, other), 0.01 - 1e-9);
    EXPECT_LT(glm::length(middle), 1.2);
  }
}

}  // namespace
}  // namespace haptics::free_place_test

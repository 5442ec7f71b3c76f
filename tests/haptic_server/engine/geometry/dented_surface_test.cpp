#include "haptic_server/engine/geometry/dented_surface.h"

#include <gtest/gtest.h>

#include <array>
#include <random>

namespace haptics::dented_surface_test {
namespace {

/// What the viewer draws: each vertex by itself.
TEST(DentedSurface, HasTheCornersOfEachVertexByItselfToTheBit) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<float> place(-0.05F, 0.05F);
  const auto somewhere = [&] { return Vec3f(place(random), place(random), place(random)); };
  int moved = 0;
  for (int i = 0; i < 2000; ++i) {
    const Falloff falloff(0.002 + 0.00005 * i, 2 + static_cast<unsigned>(i % 7));
    std::array<Dent, 3> dents;
    for (Dent& dent : dents) dent = {.centre = somewhere(), .displacement = 0.1F * somewhere()};
    TriangleRecord triangle{};
    std::array<Vec3f, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) {
      corner[k] = somewhere();
      for (std::size_t d = 0; d < 3; ++d) triangle.rows[d][k] = corner[k][static_cast<int>(d)];
      triangle.setNeighbour(static_cast<int>(k), static_cast<std::uint32_t>(random()));
    }
    const TriangleRecord now = dented(triangle, dents, falloff);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3f alone = dented(corner[k], dents, falloff);
      ASSERT_EQ(Vec3f(now.rows[0][k], now.rows[1][k], now.rows[2][k]), alone) << i;
      ASSERT_EQ(now.neighbour(static_cast<int>(k)), triangle.neighbour(static_cast<int>(k)));
      moved += alone != corner[k] ? 1 : 0;
    }
    const Double4 parts = partsOf(dents[0], cornersAtOnce(triangle), falloff);
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_EQ(parts[static_cast<int>(k)], falloff.at(Vec3(corner[k]) - Vec3(dents[0].centre))) << i;
    }
  }
  EXPECT_GT(moved, 1000);
}

}  // namespace
}  // namespace haptics::dented_surface_test

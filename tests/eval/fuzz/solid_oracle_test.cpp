#include "tests/eval/fuzz/solid_oracle.h"

#include <gtest/gtest.h>

#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::eval::solid_oracle_test {
namespace {

SolidOracle oracleOf(const shapes::Shape& shape) { return {shape.vertices, shape.triangles}; }

TEST(SolidOracle, TellsTheDepthInABoxAndNoneOutside) {
  const SolidOracle box = oracleOf(shapes::box(Vec3(0.02), 3));
  EXPECT_NEAR(box.depth_m({0.001, 0.002, 0.0099}), 0.0001, 1e-9);
  EXPECT_NEAR(box.depth_m({0.001, 0.002, 0.0099999}), 1e-7, 1e-9);
  EXPECT_EQ(box.depth_m({0.001, 0.002, 0.010001}), 0);
  EXPECT_EQ(box.depth_m({0.5, 0.002, 0}), 0);
}

TEST(SolidOracle, TakesWhatIsNearerThanVerticesAreRoundedForOnTheSurface) {
  const SolidOracle box = oracleOf(shapes::box(Vec3(0.02), 3));
  EXPECT_EQ(box.depth_m({0.001, 0.002, 0.01 - 2e-8}), 0);
  EXPECT_EQ(box.side({0.001, 0.002, 0.01 - 2e-8}), SolidOracle::Side::kOnSurface);
  EXPECT_EQ(box.side({0.001, 0.002, 0.01 - 1e-7}), SolidOracle::Side::kInside);
  EXPECT_EQ(box.side({0.001, 0.002, 0.01 + 1e-7}), SolidOracle::Side::kOutside);
}

TEST(SolidOracle, TakesLargeMeshesForAsCoarseAsTheirVertices) {
  EXPECT_EQ(oracleOf(shapes::box(Vec3(0.4), 3)).rounding_m(), SolidOracle::kMinRounding_m);
  EXPECT_EQ(oracleOf(shapes::box(Vec3(4), 3)).rounding_m(), 0x1p-22);
}

TEST(SolidOracle, CountsHowOftenAMeshThatPassesThroughItselfWindsAround) {
  shapes::Shape two = shapes::sphere(0.01, 8);
  two.add(shapes::sphere(0.01, 8), Vec3(0.012, 0, 0));
  const SolidOracle oracle = oracleOf(two);
  EXPECT_NEAR(oracle.windingNumber({0.006, 0, 0}), 2, 1e-9);
  EXPECT_NEAR(oracle.windingNumber({0, 0, 0}), 1, 1e-9);
  EXPECT_NEAR(oracle.windingNumber({0.006, 0.02, 0}), 0, 1e-9);
  EXPECT_GT(oracle.depth_m({0.006, 0.001, 0.0005}), 0);
}

/// The quick count along a ray only leaves out what the solid angles leave out too.
TEST(SolidOracle, AgreesWithTheSolidAnglesEverywhere) {
  const shapes::Shape shape = shapes::bumpy(0.03, 8);
  const SolidOracle oracle = oracleOf(shape);
  for (int i = -10; i <= 10; ++i) {
    for (int j = -10; j <= 10; ++j) {
      const Vec3 place(0.0035 * i, 0.0035 * j, 0.001 * (i + j));
      EXPECT_EQ(oracle.depth_m(place) > 0, oracle.windingNumber(place) > 0.5) << i << ' ' << j;
    }
  }
}

}  // namespace
}  // namespace haptics::eval::solid_oracle_test

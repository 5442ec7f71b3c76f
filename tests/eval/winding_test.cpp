#include "tests/eval/winding.h"

#include <gtest/gtest.h>

#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::eval::winding_test {
namespace {

WindingMesh meshOf(const shapes::Shape& shape) { return {shape.vertices, shape.triangles}; }

TEST(WindingMesh, CountsEachPassOfAMeshAroundThePoint) {
  shapes::Shape shape = shapes::box(Vec3(0.02), 2);
  shape.add(shapes::box(Vec3(0.02), 3), Vec3(0.01, 0.004, 0));
  const WindingMesh mesh = meshOf(shape);
  EXPECT_NEAR(mesh.windingNumber({0.004, 0.001, 0.002}), 2, 1e-9);
  EXPECT_NEAR(mesh.windingNumber({-0.004, 0.001, 0.002}), 1, 1e-9);
  EXPECT_NEAR(mesh.windingNumber({-0.012, 0.001, 0.002}), 0, 1e-9);
}

TEST(WindingMesh, TellsHowFarAPointIsBelowTheSurface) {
  const WindingMesh mesh = meshOf(shapes::box(Vec3(0.02)));
  const double face = 0.01F;
  EXPECT_NEAR(mesh.depthInside({0.001, 0.002, face - 40e-9}), 40e-9, 1e-12);
  EXPECT_EQ(mesh.depthInside({0.001, 0.002, face + 40e-9}), 0);
  EXPECT_NEAR(mesh.distanceTo({0.001, 0.002, face + 0.003}), 0.003, 1e-12);
}

TEST(WindingMesh, HasNoInsideInTheHoleOfATorus) {
  const WindingMesh mesh = meshOf(shapes::torus(0.03, 0.01, 48, 24));
  EXPECT_EQ(mesh.depthInside(Vec3(0)), 0);
  EXPECT_GT(mesh.depthInside({0.03, 0, 0}), 0.009);
}

TEST(InsideTicks, TellsATickAloneFromTicksInARow) {
  InsideTicks ticks;
  for (const double depth : {0.0, 1e-6, 0.0, 1e-6, 2e-6, 3e-6, 29e-9, 1e-6}) ticks.see(depth);
  EXPECT_EQ(ticks.all(), 5);
  EXPECT_EQ(ticks.single(), 2);
  EXPECT_EQ(ticks.longest(), 3);
  EXPECT_EQ(ticks.deepest_m(), 3e-6);
}

}  // namespace
}  // namespace haptics::eval::winding_test

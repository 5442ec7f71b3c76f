#include <gtest/gtest.h>

#include "common/deform/free_form.h"
#include "common/mesh/generators.h"
#include "haptic_server/scene/fit_to_mesh.h"

namespace haptics::fit_deformation_test {
namespace {

TriMesh bar() { return makeBox({0.02, 0.04, 0.1}, 8).value(); }

DeformationProperties soft(double radius_m) {
  return {.softness = Softness{.stiffness_N_per_m = 100, .radius_m = radius_m}, .lattice = {}};
}

DeformationProperties withLattice(Vec3 low, Vec3 size) {
  DeformationProperties properties;
  properties.lattice = Lattice{low, size, {2, 2, 2}, FreeForm::atRest(low, size, {2, 2, 2})};
  return properties;
}

TEST(FitDeformation, RefusesAFalloffThatReachesBeyondTheObject) {
  DeformationProperties properties = soft(0.11);
  EXPECT_EQ(fitToMesh(properties, bar(), false).value().field, "softness.radius_m");
  properties = soft(0.1);
  EXPECT_FALSE(fitToMesh(properties, bar(), false));
}

TEST(FitDeformation, RefusesDentsThatStayWhereNoneCanBeKept) {
  const TriMesh mountain = makeBox(Vec3(3000), 1).value();
  DeformationProperties properties = soft(100);
  EXPECT_FALSE(fitToMesh(properties, mountain, false));
  properties.softness->plastic = 0.5;
  EXPECT_EQ(fitToMesh(properties, mountain, false).value().field, "softness.plastic");
}

TEST(FitDeformation, RefusesALatticeThatDoesNotHoldTheMesh) {
  DeformationProperties properties = withLattice({-0.01, -0.02, -0.05}, {0.02, 0.04, 0.09});
  EXPECT_EQ(fitToMesh(properties, bar(), false).value().field, "lattice.low_m");
  properties = withLattice({-0.01, -0.02, -0.05}, {0.02, 0.04, 0.1});
  EXPECT_FALSE(fitToMesh(properties, bar(), false));
}

TEST(FitDeformation, GivesALatticeWithoutABoxThatOfTheMesh) {
  DeformationProperties properties = withLattice(Vec3(0), Vec3(1));
  EXPECT_FALSE(fitToMesh(properties, bar(), true));
  EXPECT_LT(glm::distance(properties.lattice->low_m, Vec3(-0.01, -0.02, -0.05)), 1e-8);
  EXPECT_LT(glm::distance(properties.lattice->size_m, Vec3(0.02, 0.04, 0.1)), 1e-8);
}

TEST(FitDeformation, WarnsOfAMeshTooCoarseForItsDentsAndOfFlatTriangles) {
  EXPECT_TRUE(deformationWarnings(soft(0.05), bar()).empty());
  EXPECT_EQ(deformationWarnings(soft(0.01), bar()).size(), 1U);
  DeformationProperties flat = withLattice({-0.01, -0.02, -0.05}, {0.02, 0.04, 0.1});
  EXPECT_TRUE(deformationWarnings(flat, bar()).empty());
  for (Vec3f& point : flat.lattice->control_m) point = Vec3f(0);
  EXPECT_EQ(deformationWarnings(flat, bar()).size(), 1U);
}

}  // namespace
}  // namespace haptics::fit_deformation_test

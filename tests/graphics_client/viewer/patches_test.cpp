#include "graphics_client/viewer/patches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numbers>

#include "common/mesh/generators.h"

namespace haptics::patches_test {
namespace {

constexpr std::size_t kMax = 60;

struct Cut : testing::Test {
  const TriMesh mesh = makeTorus(0.04, 0.015, 48, 48).value();
  const std::vector<Patch> patches = cutIntoPatches(mesh.vertices, mesh.triangles, kMax);
};

TEST_F(Cut, HaveEveryTriangleOnceAsItWas) {
  std::map<TriangleIndices, int> left;
  for (const TriangleIndices& t : mesh.triangles) ++left[t];
  for (const Patch& patch : patches) {
    EXPECT_LE(patch.triangles.size(), kMax);
    for (const auto& [a, b, c] : patch.triangles) --left[{patch.points[a], patch.points[b], patch.points[c]}];
  }
  EXPECT_TRUE(std::ranges::all_of(left, [](const auto& entry) { return entry.second == 0; }));
  EXPECT_GT(patches.size(), mesh.triangles.size() / kMax);
}

TEST_F(Cut, LieInTheirBallsAndFaceAboutTheirAxes) {
  for (const Patch& patch : patches) {
    EXPECT_LT(patch.radius_m, 0.05);
    EXPECT_LT(patch.spread_rad, std::numbers::pi / 2);
    for (const std::uint32_t p : patch.points) {
      EXPECT_LE(glm::distance(Vec3(mesh.vertices[p]), patch.centre), patch.radius_m);
    }
  }
}

TEST_F(Cut, FaceAwayOnlyWhereEveryTriangleDoes) {
  int away = 0;
  for (const Vec3 eye : {Vec3(0.3, 0, 0), Vec3(0, 0.1, 0.2), Vec3(0.05, 0.05, 0), Vec3(0, 0, 0)}) {
    for (const Patch& patch : patches) {
      if (!facesAway(patch, eye)) continue;
      ++away;
      for (const TriangleIndices& t : patch.triangles) {
        const auto corner = [&](std::size_t k) { return Vec3(mesh.vertices[patch.points[t[k]]]); };
        const Vec3 across = glm::cross(corner(1) - corner(0), corner(2) - corner(0));
        EXPECT_GE(glm::dot(across, corner(0) - eye), 0);
      }
    }
  }
  EXPECT_GT(away, static_cast<int>(patches.size()) / 3);
}

TEST(CutIntoPatches, LeavesASmallSurfaceWhole) {
  const TriMesh box = makeBox({1, 1, 1}, 1).value();
  const auto patches = cutIntoPatches(box.vertices, box.triangles, 12);
  ASSERT_EQ(patches.size(), 1U);
  EXPECT_EQ(patches[0].points.size(), 8U);
  EXPECT_EQ(cutIntoPatches(box.vertices, box.triangles, 11).size(), 6U);
}

}  // namespace
}  // namespace haptics::patches_test

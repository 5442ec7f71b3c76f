#include "graphics_client/surface/refined_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/mesh/generators.h"

namespace haptics::refined_mesh_test {
namespace {

constexpr std::size_t kPlenty = 1'000'000;
constexpr double kCrease_rad = 0.7;

RefinedMesh refined(const TriMesh& mesh, double longestEdge_m, std::size_t maxTriangles = kPlenty) {
  return refine(mesh, shadeMesh(mesh, kCrease_rad), longestEdge_m, maxTriangles);
}

Vec3 placeOf(const RefinedMesh& mesh, std::size_t t, std::size_t k) {
  return mesh.places[mesh.place[mesh.triangles[t][k % 3]]];
}

double area(const RefinedMesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = placeOf(mesh, t, 0);
    sum += glm::length(glm::cross(placeOf(mesh, t, 1) - a, placeOf(mesh, t, 2) - a)) / 2;
  }
  return sum;
}

/// The triangles as a mesh of places, to ask whether it is closed.
TriMesh asMesh(const RefinedMesh& refined) {
  TriMesh mesh{.vertices = {refined.places.begin(), refined.places.end()}, .triangles = refined.triangles};
  for (TriangleIndices& t : mesh.triangles) {
    for (std::uint32_t& v : t) v = refined.place[v];
  }
  return mesh;
}

TEST(RefinedMesh, HasNoLongerEdgeThanAskedForAndTheSameArea) {
  const TriMesh box = makeBox({0.05, 0.02, 0.007}, 1).value();
  const RefinedMesh mesh = refined(box, 0.001);
  EXPECT_LE(mesh.longestEdge_m, 0.001);
  EXPECT_GT(mesh.longestEdge_m, 0.0004);  // and is not far finer
  EXPECT_NEAR(area(mesh), 2 * (0.05 * 0.02 + 0.05 * 0.007 + 0.02 * 0.007), 1e-9);
}

TEST(RefinedMesh, HasNoCracks) {
  const TriMesh torus = makeTorus(0.05, 0.02, 20, 9).value();  // its inner triangles are cut less often than its outer
  const RefinedMesh mesh = refined(torus, 0.004);
  EXPECT_GT(mesh.triangles.size(), 4 * torus.triangles.size());
  EXPECT_TRUE(isClosed(asMesh(mesh)));
}

TEST(RefinedMesh, StaysWithinTheTrianglesAllowedWithEdgesOfOneLength) {
  constexpr std::size_t kMax = 5000;
  const RefinedMesh mesh = refined(makeBox({0.05, 0.05, 0.05}, 1).value(), 1e-6, kMax);
  EXPECT_LE(mesh.triangles.size(), kMax);
  EXPECT_GT(mesh.triangles.size(), kMax / 4);
  EXPECT_TRUE(isClosed(asMesh(mesh)));
}

TEST(RefinedMesh, LeavesAMeshThatIsFineEnoughOrTooLarge) {
  const TriMesh sphere = makeSphere(0.05, 16).value();
  EXPECT_EQ(refined(sphere, 1).triangles, shadeMesh(sphere, kCrease_rad).triangles);
  EXPECT_EQ(refined(sphere, 1e-4, 10).triangles.size(), sphere.triangles.size());
}

TEST(RefinedMesh, InterpolatesNormalsByEquation1) {
  const TriMesh mesh{.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}};
  const ShadedMesh shaded{.source = {0, 1, 2}, .normals = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .triangles = {{0, 1, 2}}};
  const RefinedMesh fine = refine(mesh, shaded, 0.2, kPlenty);
  ASSERT_GT(fine.normals.size(), 20U);
  for (std::size_t v = 0; v < fine.normals.size(); ++v) {
    const Vec3 p = fine.places[fine.place[v]];
    EXPECT_LT(glm::distance(fine.normals[v], glm::normalize(Vec3(1 - p.x - p.y, p.x, p.y))), 1e-12);
  }
}

TEST(RefinedMesh, KeepsCreasesSharp) {
  for (const RefinedMesh mesh = refined(makeBox({1, 1, 1}, 1).value(), 0.2);
       const TriangleIndices& t : mesh.triangles) {
    const Vec3 a = mesh.places[mesh.place[t[0]]];
    const Vec3 face = glm::normalize(glm::cross(mesh.places[mesh.place[t[1]]] - a, mesh.places[mesh.place[t[2]]] - a));
    for (const std::uint32_t v : t) EXPECT_GT(glm::dot(mesh.normals[v], face), 1 - 1e-9);
  }
}

TEST(RefinedMesh, KnowsTheEdgesOfTheMesh) {
  const TriMesh mesh{.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}};
  const RefinedMesh fine = refined(mesh, 0.1);
  double length = 0;
  for (std::size_t t = 0; t < fine.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 a = placeOf(fine, t, k), b = placeOf(fine, t, k + 1), middle = (a + b) / 2.0;
      const bool isRim = (fine.rims[t] >> k & 1) != 0;
      EXPECT_EQ(isRim, std::min({middle.x, middle.y, 1 - middle.x - middle.y}) < 1e-9);
      if (isRim) length += glm::distance(a, b);
    }
  }
  EXPECT_NEAR(length, 2 + std::sqrt(2), 1e-9);
}

TEST(RefinedMesh, NamesTheEndsOfEachEdgeThatItHalved) {
  const TriMesh sphere = makeSphere(0.05, 8).value();
  const RefinedMesh mesh = refined(sphere, 0.005);
  ASSERT_EQ(sphere.vertices.size() + mesh.parents.size(), mesh.places.size());
  ASSERT_FALSE(mesh.parents.empty());
  for (std::size_t i = 0; i < mesh.parents.size(); ++i) {
    const auto [a, b] = mesh.parents[i];
    const std::size_t place = sphere.vertices.size() + i;
    ASSERT_LT(std::max(a, b), place);
    EXPECT_EQ(mesh.places[place], (mesh.places[a] + mesh.places[b]) / 2.0);
  }
}

}  // namespace
}  // namespace haptics::refined_mesh_test

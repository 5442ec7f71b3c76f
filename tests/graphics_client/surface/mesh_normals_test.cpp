#include "graphics_client/surface/mesh_normals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/mesh/generators.h"

namespace haptics::mesh_normals_test {
namespace {

constexpr double kCrease_rad = 0.7;

/// Two triangles along the x axis, the second turned up from the first's plane by `fold_rad`.
TriMesh folded(double fold_rad) {
  const auto y = static_cast<float>(std::cos(fold_rad)), z = static_cast<float>(std::sin(fold_rad));
  return {.vertices = {{0, 0, 0}, {1, 0, 0}, {0, -1, 0}, {1, y, z}}, .triangles = {{0, 2, 1}, {0, 1, 3}}};
}

double angleBetween(Vec3f a, Vec3f b) { return std::acos(std::clamp<double>(glm::dot(a, b), -1, 1)); }

TEST(MeshNormals, StandOnTheCanonicalVerticesInCanonicalOrder) {
  const TriMesh mesh = makeBox({1, 2, 3}, 2).value();
  const ShadedMesh shaded = shadeMesh(mesh, kCrease_rad);
  ASSERT_EQ(shaded.triangles.size(), mesh.triangles.size());
  ASSERT_EQ(shaded.normals.size(), shaded.source.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(shaded.source[shaded.triangles[t][k]], mesh.triangles[t][k]);
  }
}

TEST(MeshNormals, KeepABoxSharp) {
  const TriMesh mesh = makeBox({1, 1, 1}, 1).value();
  const ShadedMesh shaded = shadeMesh(mesh, kCrease_rad);
  EXPECT_EQ(shaded.source.size(), 24U);  // each of 8 corners three times
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const TriangleIndices& i = mesh.triangles[t];
    const Vec3f face = glm::normalize(
        glm::cross(mesh.vertices[i[1]] - mesh.vertices[i[0]], mesh.vertices[i[2]] - mesh.vertices[i[0]]));
    for (const std::uint32_t v : shaded.triangles[t]) EXPECT_LT(angleBetween(shaded.normals[v], face), 1e-3);
  }
}

TEST(MeshNormals, KeepASphereSmooth) {
  const TriMesh mesh = makeSphere(0.05, 16).value();
  const ShadedMesh shaded = shadeMesh(mesh, kCrease_rad);
  ASSERT_EQ(shaded.source.size(), mesh.vertices.size());
  for (std::size_t v = 0; v < shaded.source.size(); ++v) {
    EXPECT_LT(angleBetween(shaded.normals[v], glm::normalize(mesh.vertices[shaded.source[v]])), 0.02);
  }
}

TEST(MeshNormals, SplitAnEdgeOnlyBeyondTheCreaseAngle) {
  constexpr double kMargin_rad = 0.01;
  EXPECT_EQ(shadeMesh(folded(kCrease_rad - kMargin_rad), kCrease_rad).source.size(), 4U);
  EXPECT_EQ(shadeMesh(folded(kCrease_rad + kMargin_rad), kCrease_rad).source.size(), 6U);
  EXPECT_EQ(shadeMesh(folded(-kCrease_rad + kMargin_rad), kCrease_rad).source.size(), 4U);
  EXPECT_EQ(shadeMesh(folded(-kCrease_rad - kMargin_rad), kCrease_rad).source.size(), 6U);
}

TEST(MeshNormals, KeepAnExplicitCreaseSharpWhateverItsAngle) {
  const TriMesh mesh = folded(0.1);
  const std::vector<Crease> creases = {{0, 1}}, other = {{0, 2}};
  EXPECT_EQ(shadeMesh(mesh, kCrease_rad, creases).source.size(), 6U);
  EXPECT_EQ(shadeMesh(mesh, kCrease_rad, other).source.size(), 4U);
}

TEST(MeshNormals, TakeAPlaneAsOneFaceAndNothingElseWhenFaceted) {
  EXPECT_EQ(shadeMesh(makeBox({0.05, 0.04, 0.03}, 4).value(), kSamePlane_rad).source.size(), 6U * 25U);
  EXPECT_EQ(shadeMesh(folded(0.001), kSamePlane_rad).source.size(), 6U);
}

TEST(MeshNormals, AreExactOnASphereHoweverIrregular) {
  TriMesh mesh = makeSphere(1, 16).value();
  for (Vec3f& v : mesh.vertices) v = glm::normalize(v + 0.01F * glm::sin(Vec3f(71, 83, 97) * v));
  const ShadedMesh shaded = shadeMesh(mesh, std::numbers::pi);
  for (std::size_t v = 0; v < shaded.source.size(); ++v) {
    EXPECT_LT(angleBetween(shaded.normals[v], mesh.vertices[shaded.source[v]]), 1e-3);
  }
}

TEST(MeshNormals, DoNotDependOnTheOrderOfTrianglesAndCorners) {
  const TriMesh mesh = makeTorus(0.05, 0.02, 48, 24).value();
  TriMesh turned = mesh;
  std::ranges::reverse(turned.triangles);
  for (TriangleIndices& t : turned.triangles) t = {t[1], t[2], t[0]};
  const ShadedMesh a = shadeMesh(mesh, kCrease_rad), b = shadeMesh(turned, kCrease_rad);
  ASSERT_EQ(a.source, b.source);
  for (std::size_t v = 0; v < a.normals.size(); ++v) EXPECT_LT(angleBetween(a.normals[v], b.normals[v]), 1e-3);
}

TEST(MeshNormals, AreUnitAndFiniteOnFacesWithoutArea) {
  const TriMesh mesh{.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}},
                     .triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}};
  for (const Vec3f& normal : shadeMesh(mesh, kCrease_rad).normals) EXPECT_NEAR(glm::length(normal), 1, 1e-5);
}

TEST(MeshNormals, TellClosedSurfacesFromOthers) {
  TriMesh mesh = makeBox({1, 1, 1}, 1).value();
  EXPECT_TRUE(isClosed(mesh));
  TriMesh open = mesh;
  open.triangles.pop_back();
  EXPECT_FALSE(isClosed(open));
  TriMesh flipped = mesh;
  std::swap(flipped.triangles[3][0], flipped.triangles[3][1]);
  EXPECT_FALSE(isClosed(flipped));
  TriMesh withFin = mesh;
  withFin.vertices.emplace_back(2.0F, 2.0F, 2.0F);
  const TriangleIndices& t = mesh.triangles[0];
  withFin.triangles.push_back({t[0], t[1], static_cast<std::uint32_t>(withFin.vertices.size() - 1)});
  EXPECT_FALSE(isClosed(withFin));
  TriMesh doubled = mesh;
  doubled.triangles.insert(doubled.triangles.end(), mesh.triangles.begin(), mesh.triangles.end());
  EXPECT_FALSE(isClosed(doubled));
}

}  // namespace
}  // namespace haptics::mesh_normals_test

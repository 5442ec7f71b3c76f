#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "common/mesh/generators.h"
#include "graphics_client/surface/mesh_normals.h"
#include "haptic_server/engine/surface/shading_normals.h"

namespace haptics::felt_normals_test {
namespace {

/// Viewer and servo make their normals each from its own database, by the same rule.
void expectShownAsFelt(const TriMesh& mesh, double crease_rad, const std::vector<Crease>& creases = {}) {
  const ShadedMesh shown = shadeMesh(mesh, crease_rad, creases);
  const auto built = buildCollisionMesh(mesh.vertices, mesh.triangles);
  const CollisionMesh& surface = *built;
  const ShadingNormals felt(surface, crease_rad, creases);
  for (std::uint32_t t = 0; t < surface.triangleCount(); ++t) {
    const TriangleIndices& corners = shown.triangles[surface.canonical(t)];
    for (int k = 0; k < 3; ++k) {
      const Vec3 normal = shown.normals[corners[static_cast<std::size_t>(k)]];
      EXPECT_LT(glm::distance(normal, felt[t].normal(k)), 1e-6) << "corner " << k << " of polygon " << t;
    }
  }
}

TEST(FeltNormals, AreTheShownOnesOnASmoothSurface) {
  expectShownAsFelt(makeTorus(0.05, 0.02, 24, 12).value(), 0.7);
  expectShownAsFelt(makeSphere(0.05, 8).value(), 0.7);
}

TEST(FeltNormals, AreTheShownOnesBesideCreases) {
  const TriMesh cylinder = makeCylinder(0.03, 0.08, 24).value();
  expectShownAsFelt(cylinder, 0.5);
  expectShownAsFelt(cylinder, 0.2);  // its side has lines at 0.26: all are sharp
  expectShownAsFelt(makeBox({0.1, 0.07, 0.05}, 3).value(), 0.7);
}

TEST(FeltNormals, AreTheShownOnesBesideExplicitCreases) {
  const TriMesh sphere = makeSphere(0.05, 6).value();
  std::vector<Crease> creases;
  for (std::size_t t = 0; t < sphere.triangles.size(); t += 5) {
    const auto [first, second] = std::minmax(sphere.triangles[t][0], sphere.triangles[t][1]);
    creases.push_back({first, second});
  }
  std::ranges::sort(creases);
  creases.erase(std::unique(creases.begin(), creases.end()), creases.end());
  expectShownAsFelt(sphere, 0.7, creases);
}

TEST(FeltNormals, AreTheShownOnesAtABoundary) {
  TriMesh open = makeSphere(0.05, 6).value();
  open.triangles.resize(open.triangles.size() - 3);
  expectShownAsFelt(open, 0.7);
}

}  // namespace
}  // namespace haptics::felt_normals_test

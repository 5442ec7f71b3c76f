#include "haptic_server/engine/surface/shading_normals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "common/mesh/generators.h"

namespace haptics::shading_normals_test {
namespace {

constexpr double kAll = std::numbers::pi;
constexpr double kSixtyDegrees = std::numbers::pi / 3;

std::shared_ptr<const CollisionMesh> surfaceOf(const TriMesh& mesh) {
  return buildCollisionMesh(mesh.vertices, mesh.triangles);
}

/// Largest angle (rad) between a corner's normal and `expected(corner, polygon's normal)`.
template <class Expected>
double worst(const CollisionMesh& surface, const ShadingNormals& normals, Expected expected) {
  double most = 0;
  for (std::uint32_t t = 0; t < surface.triangleCount(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 right = expected(surface.triangle(t).corner(k), surface.faceNormal(t));
      most = std::max(most, glm::length(glm::cross(normals[t].normal(k), right)));
    }
  }
  return most;
}

TEST(ShadingNormals, AreThoseOfTheSphereThatTheVerticesLieOn) {
  for (const std::uint32_t segments : {1U, 5U, 40U}) {
    const auto sphere = surfaceOf(makeSphere(0.05, segments).value());
    const ShadingNormals normals(*sphere, kAll, {});
    EXPECT_LT(worst(*sphere, normals, [](Vec3 p, Vec3) { return glm::normalize(p); }), 1e-5) << segments;
  }
}

TEST(ShadingNormals, KeepTheEdgesOfABoxSharpAndItsSidesFlat) {
  const auto box = surfaceOf(makeBox(Vec3(0.1), 6).value());
  const ShadingNormals normals(*box, kSixtyDegrees, {});
  EXPECT_LT(worst(*box, normals, [](Vec3, Vec3 face) { return face; }), 1e-6);
  int sharp = 0;
  for (std::uint32_t t = 0; t < box->triangleCount(); ++t) {
    for (int k = 0; k < 3; ++k) {
      sharp += normals[t].sharpLine(k) ? 1 : 0;
      EXPECT_TRUE(!normals[t].sharpLine(k) || (normals[t].sharpVertex(k) && normals[t].sharpVertex(nextCorner(k))));
    }
  }
  EXPECT_EQ(sharp, 2 * 12 * 6) << "twelve edges of six lines, each seen from both sides";
}

TEST(ShadingNormals, SplitAtTheRimOfACylinder) {
  const auto cylinder = surfaceOf(makeCylinder(0.02, 0.08, 48).value());
  const ShadingNormals normals(*cylinder, kSixtyDegrees, {});
  EXPECT_LT(worst(*cylinder, normals,
                  [](Vec3 p, Vec3 face) { return std::abs(face.z) > 0.5 ? face : glm::normalize(Vec3(p.x, p.y, 0)); }),
            1e-5);
}

TEST(ShadingNormals, KeepAnExplicitCreaseSharpWhateverItsAngle) {
  const auto sphere = surfaceOf(makeSphere(0.05, 8).value());
  const TriangleRecord& r = sphere->triangle(17);
  const std::uint32_t a = r.vertexAt(0), b = r.vertexAt(1);
  const std::array<std::array<std::uint32_t, 2>, 1> crease{{{std::min(a, b), std::max(a, b)}}};
  const ShadingNormals normals(*sphere, kAll, crease);
  int sharp = 0;
  for (std::uint32_t t = 0; t < sphere->triangleCount(); ++t) {
    for (int k = 0; k < 3; ++k) sharp += normals[t].sharpLine(k) ? 1 : 0;
  }
  EXPECT_TRUE(normals[17].sharpLine(0));
  EXPECT_EQ(sharp, 2);
}

TEST(ShadingNormals, TellHowRoundOrHollowTheSurfaceIs) {
  TriMesh mesh = makeSphere(0.05, 20).value();
  const auto round = surfaceOf(mesh);
  for (TriangleIndices& t : mesh.triangles) std::swap(t[1], t[2]);
  const auto hollow = surfaceOf(mesh);
  const ShadingNormals outer(*round, kAll, {}), inner(*hollow, kAll, {});
  for (std::uint32_t t = 0; t < round->triangleCount(); ++t) {
    EXPECT_NEAR(outer[t].roundness(0), 20, 0.3);
    EXPECT_EQ(outer[t].hollowness[0], 0);
    EXPECT_NEAR(inner[t].hollowness[0], 20, 0.3);
    EXPECT_EQ(inner[t].roundness(0), 0);
  }
}

}  // namespace
}  // namespace haptics::shading_normals_test

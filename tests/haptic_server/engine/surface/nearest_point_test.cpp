#include "haptic_server/engine/surface/nearest_point.h"

#include <gtest/gtest.h>

#include <random>

#include "common/mesh/generators.h"

namespace haptics::nearest_point_test {
namespace {

std::shared_ptr<const CollisionMesh> torus() {
  const TriMesh mesh = makeTorus(0.04, 0.015, 48, 32).value();
  return buildCollisionMesh(mesh.vertices, mesh.triangles);
}

double bruteForce_m(const CollisionMesh& surface, Vec3 h) {
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t t = 0; t < surface.triangleCount(); ++t) {
    least = std::min(least, closestOn(surface.triangle(t), t, h).squaredDistance);
  }
  return std::sqrt(least);
}

TEST(NearestPoint, IsThatOfTheWholeMeshWhateverTheHint) {
  const auto surface = torus();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-0.07, 0.07);
  for (int i = 0; i < 500; ++i) {
    const Vec3 h(place(random), place(random), place(random));
    const std::uint32_t hint =
        i % 2 == 0 ? kNoTriangle : static_cast<std::uint32_t>(random() % surface->triangleCount());
    Allowance endless;
    const ClosestPoint foot = nearestPoint(*surface, h, 1, hint, endless);
    EXPECT_NEAR(std::sqrt(foot.squaredDistance), bruteForce_m(*surface, h), 1e-12);
  }
}

TEST(NearestPoint, IsNoneBeyondItsReach) {
  const auto surface = torus();
  Allowance endless;
  const Vec3 above(0.04, 0, 0.025);  // 10 mm over the top of the tube
  EXPECT_EQ(nearestPoint(*surface, above, 0.009, kNoTriangle, endless).triangle, kNoTriangle);
  EXPECT_NE(nearestPoint(*surface, above, 0.0101, kNoTriangle, endless).triangle, kNoTriangle);
}

}  // namespace
}  // namespace haptics::nearest_point_test

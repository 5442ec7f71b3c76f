// Meshes that pass through themselves everywhere, as a bad scan does in places, also around one vertex.

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "haptic_server/engine/contact/contact.h"
#include "tests/haptic_server/engine/contact/contact_rig.h"

namespace haptics::self_intersecting_test {
namespace {

/// A ball whose vertices are displaced by up to `disorder` of an edge.
shapes::Shape crumpledBall(double disorder) {
  constexpr int kDivisions = 6;
  constexpr double kRadius_m = 0.04;
  constexpr double kEdge_m = kRadius_m * std::numbers::pi / 2 / kDivisions;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> offset(-disorder * kEdge_m, disorder * kEdge_m);
  return shapes::sphere(kRadius_m, kDivisions).mapped([&](Vec3 v) {
    const double x = offset(random);
    const double y = offset(random);
    return v + Vec3(x, y, offset(random));
  });
}

/// How often the surface winds around a point: the sum of the solid angles of its triangles (Van Oosterom and Strackee
/// 1983). A part turned inside out winds the other way.
double windingAround(const CollisionMesh& s, Vec3 p) {
  double angle = 0;
  for (std::uint32_t t = 0; t < s.triangleCount(); ++t) {
    const TriangleRecord& r = s.triangle(t);
    const Vec3 a = glm::normalize(r.corner(0) - p);
    const Vec3 b = glm::normalize(r.corner(1) - p);
    const Vec3 c = glm::normalize(r.corner(2) - p);
    angle += 2 * std::atan2(glm::dot(a, glm::cross(b, c)), 1 + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a));
  }
  return angle / (4 * std::numbers::pi);
}

class SelfIntersectingBall : public testing::TestWithParam<double> {};

TEST_P(SelfIntersectingBall, IsNeverEntered) {
  constexpr int kTicks = 40'000;
  constexpr double kDeepest = 2e-7;  // m: the skin and the vertices' rounding
  const auto surface = crumpledBall(GetParam()).build();
  ASSERT_TRUE(surface->anySelfIntersecting());
  ContactRig world(surface);
  std::mt19937_64 random(3);
  std::normal_distribution<double> push(0, 1);
  Vec3 hip(0.001, 0.002, 0.09);
  world.place(hip);
  Vec3 speed(0);  // m per tick
  int touching = 0;
  int notConverged = 0;
  for (int i = 0; i < kTicks; ++i) {
    speed = speed * 0.9 + Vec3(push(random), push(random), push(random)) * 0.0004;
    speed -= hip * (0.01 * (glm::length(hip) - 0.030) / glm::length(hip));
    hip += speed;
    const ContactResult r = world.tick(hip);
    ASSERT_TRUE(r.touching || r.ihip == hip);
    int spent = 0;
    const ClosestPoint foot = surface->closestFoot(r.ihip, static_cast<int>(surface->triangleCount()) + 1, spent);
    if (foot.squaredDistance > kDeepest * kDeepest) {
      ASSERT_LT(windingAround(*surface, r.ihip), 0.5) << "tick " << i;
    }
    touching += r.touching ? 1 : 0;
    notConverged += r.work.notConverged ? 1 : 0;
  }
  EXPECT_GT(touching, kTicks / 4);
  EXPECT_LT(notConverged, kTicks / 50);
}

INSTANTIATE_TEST_SUITE_P(ByDisorder, SelfIntersectingBall, testing::Values(0.7, 1.0), [](const auto& disorder) {
  return "ByTenthsOfAnEdge" + std::to_string(static_cast<int>(10 * disorder.param + 0.5));
});

}  // namespace
}  // namespace haptics::self_intersecting_test

#include "haptic_server/engine/contact/plane_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace haptics::plane_set_test {
namespace {

ConstraintPlane plane(Vec3 normal, double offset, int body = 0) {
  return {glm::normalize(normal), offset, {body, 1, 0}};
}

TEST(PlaneSet, EmptySetReturnsTheHip) {
  const auto found = PlaneSet().nearest({1, 2, 3}, 0);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->point, Vec3(1, 2, 3));
  EXPECT_EQ(found->tightCount, 0);
}

TEST(PlaneSet, OneTwoThreePlanesProjectOntoPlaneLinePoint) {
  PlaneSet set;
  set.add(plane({0, 0, 1}, 0, 10));
  auto found = set.nearest({-1, -2, -3}, 1e-12);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->point, Vec3(-1, -2, 0));
  set.add(plane({1, 0, 0}, 0, 11));
  found = set.nearest({-1, -2, -3}, 1e-12);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->point, Vec3(0, -2, 0));
  set.add(plane({0, 1, 0}, 0, 12));
  found = set.nearest({-1, -2, -3}, 1e-12);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->point, Vec3(0));
  ASSERT_EQ(found->tightCount, 3);
  // The strongest first.
  EXPECT_EQ(set[found->tight[0]].surface.body, 10);
  EXPECT_EQ(set[found->tight[1]].surface.body, 12);
  EXPECT_EQ(set[found->tight[2]].surface.body, 11);
}

TEST(PlaneSet, NegativeMultiplierReleasesThePlane) {
  PlaneSet set;
  set.add(plane({0.3, 0, 1}, 0));
  set.add(plane({0, 0, 1}, 1));
  const auto found = set.nearest({0, 0, -1}, 1e-12);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->tightCount, 1);
  EXPECT_NEAR(glm::distance(found->point, Vec3(0, 0, 1)), 0, 1e-15);
}

TEST(PlaneSet, InfeasibleSetHasNoPoint) {
  PlaneSet set;
  set.add(plane({0, 0, 1}, 1));
  set.add(plane({0, 0, -1}, 1));
  EXPECT_FALSE(set.nearest({0, 0, 0}, 1e-12));
}

/// Dykstra's alternating projections converge to the same point by another way.
Vec3 dykstra(const std::vector<ConstraintPlane>& planes, Vec3 h) {
  std::vector<Vec3> correction(planes.size(), Vec3(0));
  Vec3 x = h;
  for (int round = 0; round < 4000; ++round) {
    for (std::size_t i = 0; i < planes.size(); ++i) {
      const Vec3 y = x + correction[i];
      const double below = std::max(0.0, planes[i].offset - glm::dot(planes[i].normal, y));
      x = y + planes[i].normal * below;
      correction[i] = y - x;
    }
  }
  return x;
}

TEST(PlaneSet, NearestPointIsIndependentOfPlaneOrder) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> at(-1, 1);
  const auto vector = [&] { return Vec3(at(random), at(random), at(random)); };
  for (int i = 0; i < 200; ++i) {
    // Planes that the point (0, 0, 3) satisfies, so that there is an answer.
    std::vector<ConstraintPlane> planes;
    while (planes.size() < 4) {
      const Vec3 n = glm::normalize(vector() + Vec3(0, 0, 1.2));
      if (n.z > 0.2) planes.push_back(plane(n, at(random) * 0.5));
    }
    const Vec3 h = vector() - Vec3(0, 0, 1);
    const Vec3 expected = dykstra(planes, h);
    std::sort(planes.begin(), planes.end(), [](const auto& a, const auto& b) { return a.offset < b.offset; });
    do {
      PlaneSet set;
      Vec3 x = h;
      // As the solver does: a plane is added when it cuts off the answer so far.
      while (true) {
        const auto broken = std::find_if(planes.begin(), planes.end(), [&](const ConstraintPlane& p) {
          return glm::dot(p.normal, x) < p.offset - 1e-9;
        });
        if (broken == planes.end()) break;
        ASSERT_FALSE(set.full());
        set.add(*broken);
        const auto found = set.nearest(h, 1e-10);
        ASSERT_TRUE(found);
        x = found->point;
      }
      EXPECT_NEAR(glm::distance(x, expected), 0, 1e-5);
    } while (std::next_permutation(planes.begin(), planes.end(),
                                   [](const auto& a, const auto& b) { return a.offset < b.offset; }));
  }
}

}  // namespace
}  // namespace haptics::plane_set_test

#include "haptic_server/engine/geometry/closest_point.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace haptics::closest_point_test {
namespace {

using Corners = std::array<Vec3f, 3>;
using Wide = glm::vec<3, long double>;

TriangleRecord record(const Corners& corners) {
  TriangleRecord r{};
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t d = 0; d < 3; ++d) r.rows[d][k] = corners[k][static_cast<int>(d)];
  }
  return r;
}

/// Smallest distance by trying every primitive in extended precision.
long double referenceDistance(const Corners& corners, Vec3 h) {
  const Wide p(h);
  const std::array<Wide, 3> c{Wide(corners[0]), Wide(corners[1]), Wide(corners[2])};
  long double best = glm::distance(p, c[0]);
  for (std::size_t k = 0; k < 3; ++k) {
    const Wide e = c[(k + 1) % 3] - c[k];
    const long double s = std::clamp(glm::dot(p - c[k], e) / glm::dot(e, e), 0.0L, 1.0L);
    best = std::min(best, glm::distance(p, c[k] + e * s));
  }
  const Wide n = glm::cross(c[1] - c[0], c[2] - c[0]);
  bool inside = glm::dot(n, n) > 0;
  for (std::size_t k = 0; k < 3; ++k) {
    inside = inside && glm::dot(glm::cross(n, c[(k + 1) % 3] - c[k]), p - c[k]) >= 0;
  }
  if (inside) best = std::min(best, std::abs(glm::dot(n, p - c[0])) / glm::length(n));
  return best;
}

class ClosestPointOfTriangle : public testing::Test {
 protected:
  Vec3 point(double size) {
    std::uniform_real_distribution<double> at(-size, size);
    return {at(random_), at(random_), at(random_)};
  }
  void expectRight(const Corners& corners, Vec3 h) {
    const ClosestPoint foot = closestOn(record(corners), 7, h);
    const auto reference = static_cast<double>(referenceDistance(corners, h));
    EXPECT_EQ(foot.triangle, 7U);
    EXPECT_NEAR(std::sqrt(foot.squaredDistance), reference, 1e-12 * (reference + glm::length(h)));
    EXPECT_NEAR(glm::distance(foot.point, h), reference, 1e-12 * (reference + glm::length(h)));
  }
  std::mt19937_64 random_{1};
};

TEST_F(ClosestPointOfTriangle, IsTheNearestOfAllPrimitivesForEveryOrderOfTheCorners) {
  for (int i = 0; i < 2000; ++i) {
    Corners corners{Vec3f(point(1)), Vec3f(point(1)), Vec3f(point(1))};
    const Vec3 h = point(2);
    std::array<std::size_t, 3> order{0, 1, 2};
    do {
      expectRight({corners[order[0]], corners[order[1]], corners[order[2]]}, h);
    } while (std::next_permutation(order.begin(), order.end()));
  }
}

TEST_F(ClosestPointOfTriangle, HoldsOnNeedlesAndOnCornersThatLieOnALine) {
  for (int i = 0; i < 5000; ++i) {
    const double width = i % 2 == 0 ? 5e-5 : 1e-7;  // 20 x 0.001 mm, and as thin as floats can say
    const Corners needle{Vec3f(0), Vec3f(0.02F, 0, 0),
                         Vec3f(static_cast<float>(0.01 + point(0.02).x), static_cast<float>(0.02 * width), 0)};
    expectRight(needle, point(0.02));
    const Corners line{Vec3f(0), Vec3f(0.02F, 0, 0), Vec3f(static_cast<float>(point(0.04).x), 0, 0)};
    expectRight(line, point(0.02));
  }
}

TEST_F(ClosestPointOfTriangle, NamesThePrimitiveAndGivesTiesToTheLowerDimension) {
  const TriangleRecord r = record({Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(0, 1, 0)});
  const auto expect = [&](Vec3 h, Feature feature, int index) {
    const ClosestPoint foot = closestOn(r, 0, h);
    EXPECT_EQ(foot.feature, feature) << h.x << " " << h.y;
    EXPECT_EQ(foot.index, index) << h.x << " " << h.y;
  };
  expect({0.25, 0.25, -1}, Feature::kPolygon, 0);
  expect({0.5, -1, 1}, Feature::kLine, 0);
  expect({0.5, 0, 1}, Feature::kLine, 0);  // exactly over the line
  expect({1, 1, 0}, Feature::kLine, 1);
  expect({-1, 0.5, 0}, Feature::kLine, 2);
  expect({-1, -1, 0}, Feature::kVertex, 0);
  expect({0, 0, 3}, Feature::kVertex, 0);  // exactly over the vertex
  expect({0, -1, 0}, Feature::kVertex, 0);
  expect({2, 0, 0}, Feature::kVertex, 1);
  expect({0, 2, 0}, Feature::kVertex, 2);
}

TEST_F(ClosestPointOfTriangle, FromInsideAnObtuseCornersShadowIsStillOnTheRightEdge) {
  // The angle at corner 1 is 170 degrees: beyond edge 0 and past its end, yet nearest to edge 1.
  const Corners obtuse{Vec3f(-1, 0, 0), Vec3f(0, 0, 0), Vec3f(0.98F, 0.17F, 0)};
  for (int i = 0; i < 2000; ++i) expectRight(obtuse, point(1));
}

}  // namespace
}  // namespace haptics::closest_point_test

#include "haptic_server/engine/geometry/enclosure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::enclosure_test {
namespace {

/// Two balls as one mesh.
shapes::Shape joinedBalls(int n) {
  shapes::Shape both = shapes::sphere(0.04, n);
  both.add(shapes::sphere(0.03, n), {0.03, 0, 0});
  return both;
}

/// Solid angle of all triangles (Van Oosterom and Strackee 1983).
double solidAngleWinding(const shapes::Shape& shape, Vec3 at) {
  double sum = 0;
  for (const auto& t : shape.triangles) {
    const Vec3 a = Vec3(shape.vertices[t[0]]) - at, b = Vec3(shape.vertices[t[1]]) - at,
               c = Vec3(shape.vertices[t[2]]) - at;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    sum += std::atan2(glm::dot(a, glm::cross(b, c)),
                      la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return sum / (2 * std::numbers::pi);
}

int windingOf(const CollisionMesh& surface, Vec3 at) {
  Allowance endless;
  return windingNumber(surface, at, endless);
}

TEST(WindingNumber, IsThatOfTheSolidAngleEverywhere) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> within(-0.08, 0.08);
  for (const shapes::Shape& shape :
       {shapes::box(Vec3(0.1), 4), shapes::torus(0.04, 0.015, 24, 12), shapes::bumpy(0.05, 8), joinedBalls(8)}) {
    const auto surface = shape.build();
    for (int i = 0; i < 3000; ++i) {
      const Vec3 at(within(random), within(random), within(random));
      ASSERT_EQ(windingOf(*surface, at), std::lround(solidAngleWinding(shape, at))) << i;
    }
  }
}

TEST(WindingNumber, IsThatOfAPlaceThatLiesEvenlyToTheMesh) {
  const auto cube = shapes::box(Vec3(0.1), 4).build();
  EXPECT_EQ(windingOf(*cube, Vec3(0)), 1);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double x : {-0.0499999, -0.025, 0.025, 0.0499999}) {
      Vec3 at(0);
      at[axis] = x;
      EXPECT_EQ(windingOf(*cube, at), 1);
      at[axis] = x < 0 ? -0.0500001 : 0.0500001;
      EXPECT_EQ(windingOf(*cube, at), 0);
    }
  }
}

TEST(LeavesAt, IsWhereTheLastOfTwoPartsThatPassThroughEachOtherEnds) {
  const auto both = joinedBalls(48).build();
  EXPECT_EQ(windingOf(*both, {0.02, 0.001, 0.002}), 2);
  EXPECT_EQ(windingOf(*both, {-0.02, 0.001, 0.002}), 1);
  Allowance endless;
  const Vec3 from(-0.02, 0, 0);
  const Vec3 to(0.1, 0, 0);
  EXPECT_NEAR(leavesAt(*both, 1, from, to, endless), (0.06 + 0.02) / 0.12, 1e-3);
  EXPECT_NEAR(leavesAt(*both, 2, {0.02, 0, 0}, to, endless), 0.04 / 0.08, 1e-3);
}

}  // namespace
}  // namespace haptics::enclosure_test

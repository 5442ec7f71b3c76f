#include "haptic_server/engine/geometry/segment.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::segment_test {
namespace {

using shapes::Shape;

/// Counts segments through `aim` from outside to inside of a star-shaped body about the origin that enter nothing.
int leaks(const CollisionMesh& surface, const std::vector<Vec3>& aims, int each, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> at(-0.3, 0.3);
  int lost = 0;
  for (const Vec3 aim : aims) {
    for (int i = 0; i < each; ++i) {
      const Vec3 inside = aim * 0.5 + Vec3(at(random), at(random), at(random)) * glm::length(aim);
      const Vec3 from = aim + (aim - inside) * 1.7;
      int spent = 0;
      const bool starIn = !surface.isOutside(surface.closestFoot(inside, 1 << 20, spent), inside);
      const bool starOut = surface.isOutside(surface.closestFoot(from, 1 << 20, spent), from);
      if (!starIn || !starOut) continue;
      if (!surface.firstCrossing(from, inside)) ++lost;
    }
  }
  return lost;
}

std::vector<Vec3> verticesAndLinePoints(const Shape& shape) {
  std::vector<Vec3> aims;
  for (const Vec3f v : shape.vertices) aims.emplace_back(v);
  for (std::size_t t = 0; t < shape.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k)
      aims.push_back(glm::mix(shape.corner(t, k), shape.corner(t, (k + 1) % 3), 0.375));
  }
  return aims;
}

// S5 of the failure scenes.
TEST(Segment, NeverSlipsBetweenNeighbours) {
  const Shape ball = shapes::sphere(0.05, 24);
  const Shape cube = shapes::box({0.1, 0.1, 0.1}, 4);
  const Shape rough = shapes::bumpy(0.05, 16);
  EXPECT_EQ(leaks(*ball.build(), verticesAndLinePoints(ball), 3, 1), 0);
  EXPECT_EQ(leaks(*cube.build(), verticesAndLinePoints(cube), 50, 2), 0);
  EXPECT_EQ(leaks(*rough.build(), verticesAndLinePoints(rough), 4, 3), 0);
}

TEST(Segment, EntersWhereItMeetsLinesAndVerticesExactly) {
  const Shape cube = shapes::box({2, 2, 2}, 4);
  const auto surface = cube.build();
  for (double x = -0.875; x < 1; x += 0.125) {
    for (double y = -0.875; y < 1; y += 0.125) {
      for (int axis = 0; axis < 3; ++axis) {
        for (const double end : {1.0, -1.0}) {
          Vec3 from(x, y, x);
          Vec3 to = from;
          from[axis] = end * 1.5;
          to[axis] = end * 0.5;
          const Crossing crossing = surface->firstCrossing(from, to);
          EXPECT_TRUE(crossing);
          EXPECT_EQ(crossing.time, 0.5);
        }
      }
    }
  }
}

TEST(Segment, EntersAtOneOfManyNeedlesAroundAnApex) {
  for (const int valence : {3, 8, 64, 1024}) {
    const Shape cone = shapes::cone(0.03, 0.05, valence);
    const auto surface = cone.build();
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> at(-0.005, 0.005);
    for (int i = 0; i < 2000; ++i) {
      const Vec3 apex(cone.vertices[0]);
      const Vec3 inside{at(random), at(random), 0.02};
      EXPECT_TRUE(surface->firstCrossing(apex + (apex - inside), inside)) << valence;
    }
  }
}

TEST(Segment, EntersAClosedBodyFromOutsideOnly) {
  const auto cube = shapes::box({2, 2, 2}).build();
  const Crossing in = cube->firstCrossing({0.2, 0.3, 5}, {0.2, 0.3, 0});
  ASSERT_TRUE(in);
  EXPECT_DOUBLE_EQ(in.time, 0.8);
  EXPECT_EQ(in.side, 1);
  EXPECT_FALSE(cube->firstCrossing({0.2, 0.3, 0}, {0.2, 0.3, 5}));
  EXPECT_FALSE(cube->firstCrossing({0.2, 0.3, 5}, {0.2, 0.3, 1.5}));
  EXPECT_FALSE(cube->firstCrossing({0.2, 0.3, 5}, {0.2, 0.3, 5}));
}

TEST(Segment, EntersASheetFromBothSidesAndTellsWhich) {
  const auto sheet = shapes::sheet(2, 3).build();
  ASSERT_FALSE(sheet->closed());
  EXPECT_EQ(sheet->firstCrossing({0.1, 0.2, 1}, {0.1, 0.2, -1}).side, 1);
  EXPECT_EQ(sheet->firstCrossing({0.1, 0.2, -1}, {0.1, 0.2, 1}).side, -1);
}

TEST(Segment, PathsThatMeetOnTheSurfaceEnterExactlyOnce) {
  for (const bool closed : {true, false}) {
    const auto surface = closed ? shapes::box({2, 2, 2}).mapped([](Vec3 v) { return v - Vec3(0, 0, 1); }).build()
                                : shapes::sheet(2, 3).build();
    for (const double x : {0.0, 0.25, 0.3}) {
      const Vec3 above{x, 0.1, 0.5};
      const Vec3 on{x, 0.1, 0};
      const Vec3 below{x, 0.1, -0.5};
      EXPECT_FALSE(surface->firstCrossing(above, on));
      EXPECT_TRUE(surface->firstCrossing(on, below));
      EXPECT_FALSE(surface->firstCrossing(on, above));
      if (closed) continue;
      EXPECT_TRUE(surface->firstCrossing(below, on));  // and so not once more from there
    }
  }
}

TEST(Segment, IsTheSameForEveryOrderOfTheCorners) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> at(-1, 1);
  const auto point = [&] { return Vec3(at(random), at(random), at(random)); };
  for (int i = 0; i < 5000; ++i) {
    const Shape one{{Vec3f(point()), Vec3f(point()), Vec3f(point())}, {{0, 1, 2}}};
    const Vec3 from = point();
    const Vec3 to = point();
    const Crossing expected = one.build()->firstCrossing(from, to);
    for (const std::array<std::uint32_t, 3> order :
         {std::array{1U, 2U, 0U}, std::array{2U, 0U, 1U}, std::array{0U, 2U, 1U}}) {
      const Crossing turned = Shape{one.vertices, {order}}.build()->firstCrossing(from, to);
      ASSERT_EQ(static_cast<bool>(turned), static_cast<bool>(expected));
      if (expected) {
        EXPECT_NEAR(turned.time, expected.time, 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace haptics::segment_test

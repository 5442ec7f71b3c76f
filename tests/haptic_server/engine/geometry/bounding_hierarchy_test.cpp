#include "haptic_server/engine/geometry/bounding_hierarchy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::bounding_hierarchy_test {
namespace {

using shapes::Shape;

Crossing bruteCrossing(const CollisionMesh& s, Vec3 from, Vec3 to) {
  Crossing first;
  const Segment segment(from, to);
  for (std::uint32_t t = 0; t < s.triangleCount(); ++t) {
    Crossing c{t};
    if (segment.enters(s.triangle(t), !s.closed(), c) && (!first || c.time < first.time)) first = c;
  }
  return first;
}

ClosestPoint bruteFoot(const CollisionMesh& s, Vec3 h) {
  ClosestPoint best;
  for (std::uint32_t t = 0; t < s.triangleCount(); ++t) {
    const ClosestPoint foot = closestOn(s.triangle(t), t, h);
    if (foot.squaredDistance < best.squaredDistance) best = foot;
  }
  return best;
}

class Hierarchy : public testing::TestWithParam<Shape> {
 protected:
  Vec3 point(double size) {
    std::uniform_real_distribution<double> at(-size, size);
    return {at(random_), at(random_), at(random_)};
  }
  std::mt19937_64 random_{1};
};

std::vector<Shape> manyShapes() {
  Shape soup;
  std::mt19937_64 random(2);
  std::uniform_real_distribution<float> at(-0.05F, 0.05F);
  for (std::uint32_t i = 0; i < 600; i += 3) {
    const Vec3f c(at(random), at(random), at(random));
    for (int k = 0; k < 3; ++k) soup.vertices.push_back(c + 0.3F * Vec3f(at(random), at(random), at(random)));
    soup.triangles.push_back({i, i + 1, i + 2});
  }
  Shape stack;
  for (int i = 0; i < 200; ++i) stack.add(shapes::box({0.1, 0.1, 0.01}));
  Shape growing;
  for (int i = 0; i < 60; ++i) growing.add(shapes::box(Vec3(1e-9 * std::pow(1.35, i))), Vec3(2e-9 * std::pow(1.35, i)));
  return {shapes::bumpy(0.05, 8),
          shapes::box({0.1, 0.05, 0.0005}),
          shapes::torus(0.05, 0.02, 40, 20),
          soup,
          stack,
          growing,
          shapes::cone(0.03, 0.05, 512)};
}

TEST_P(Hierarchy, VisitsTheSameLeavesInTheSameOrderByFourBoxesAndByEight) {
  const Shape& shape = GetParam();
  BoundingHierarchy byEight;
  static_cast<void>(byEight.build(shape.vertices, shape.triangles, 0.1, 1));
  BoundingHierarchy byFour = byEight;
  byFour.setWide(false);
  const auto leavesOf = [](const BoundingHierarchy& hierarchy, Vec3f low, Vec3f high) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> leaves;
    Allowance endless;
    hierarchy.visitBox(low, high, endless,
                       [&](std::uint32_t begin, std::uint32_t end) { leaves.emplace_back(begin, end); });
    return leaves;
  };
  std::size_t visited = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3f a(point(0.06));
    const Vec3f b = a + Vec3f(point(i % 2 == 0 ? 0.001 : 0.03));
    const auto leaves = leavesOf(byEight, glm::min(a, b), glm::max(a, b));
    visited += leaves.size();
    ASSERT_EQ(leavesOf(byFour, glm::min(a, b), glm::max(a, b)), leaves);
  }
  EXPECT_GT(visited, 100U);
}

TEST_P(Hierarchy, FindsTheFirstCrossingThatAllTrianglesTogetherHave) {
  const auto s = GetParam().build();
  for (int i = 0; i < 1000; ++i) {
    const Vec3 from = point(0.1);
    const Vec3 to = i % 2 == 0 ? point(0.1) : from + point(0.002);
    const Crossing expected = bruteCrossing(*s, from, to);
    const Crossing found = s->firstCrossing(from, to);
    ASSERT_EQ(static_cast<bool>(found), static_cast<bool>(expected));
    if (expected) {
      EXPECT_EQ(found.time, expected.time);
    }
  }
}

TEST_P(Hierarchy, FindsTheFirstCrossingOfMotionsAsShortAsATicks) {
  const auto s = GetParam().build();
  const double size = BoundingHierarchy::kShort *
                      std::max({s->high().x - s->low().x, s->high().y - s->low().y, s->high().z - s->low().z});
  int crossings = 0;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const TriangleRecord& r = s->triangle(i % s->triangleCount());
    const Vec3 near = (r.corner(0) + r.corner(1) + r.corner(2)) / 3.0;
    const Vec3 from = near + point(size);
    const Vec3 to = from + point(size * (i % 2 == 0 ? 0.9 : 0.1));
    const Crossing expected = bruteCrossing(*s, from, to);
    const Crossing found = s->firstCrossing(from, to);
    ASSERT_EQ(static_cast<bool>(found), static_cast<bool>(expected));
    if (expected) {
      ++crossings;
      EXPECT_EQ(found.time, expected.time);
    }
  }
  EXPECT_GT(crossings, 10);
}

TEST_P(Hierarchy, FindsCrossingsFromFarAway) {
  const auto s = GetParam().build();
  for (int i = 0; i < 1000; ++i) {
    const Vec3 from = point(100'000);
    const Vec3 to = point(0.03);
    EXPECT_EQ(static_cast<bool>(s->firstCrossing(from, to)), static_cast<bool>(bruteCrossing(*s, from, to)));
  }
}

TEST_P(Hierarchy, IsNotMetByAMotionThatIsNotFinite) {
  const auto s = GetParam().build();
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    for (int k = 0; k < 4; ++k) {
      Vec3 end = k < 3 ? point(0.1) : Vec3(bad);
      if (k < 3) end[k] = bad;
      EXPECT_FALSE(s->firstCrossing(point(0.1), end));
      EXPECT_FALSE(s->firstCrossing(end, point(0.1)));
      EXPECT_FALSE(s->firstCrossing(end, end));
    }
  }
}

TEST_P(Hierarchy, FindsTheClosestPointThatAllTrianglesTogetherHave) {
  const auto s = GetParam().build();
  for (int i = 0; i < 500; ++i) {
    const Vec3 h = point(0.1);
    int spent = 0;
    const ClosestPoint found = s->closestFoot(h, 1 << 20, spent);
    EXPECT_EQ(found.squaredDistance, bruteFoot(*s, h).squaredDistance);
    if (!s->hierarchy().hasCells()) {
      EXPECT_LE(spent, static_cast<int>(s->triangleCount()));
    }
  }
}

TEST_P(Hierarchy, KeepsEveryTriangleOnceAndItsCornersInOrder) {
  const Shape& shape = GetParam();
  const auto s = shape.build();
  std::vector<std::uint32_t> seen(shape.triangles.size());
  for (std::uint32_t t = 0; t < s->triangleCount(); ++t) {
    seen[t] = s->canonical(t);
    EXPECT_EQ(s->triangle(t).vertex, shape.triangles[s->canonical(t)]);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(s->triangle(t).corner(k), shape.corner(s->canonical(t), static_cast<std::size_t>(k)));
    }
  }
  std::sort(seen.begin(), seen.end());
  std::vector<std::uint32_t> all(seen.size());
  std::iota(all.begin(), all.end(), 0U);
  EXPECT_EQ(seen, all);
}

TEST_P(Hierarchy, IsNotDeeperThanTheQueriesStacksAllow) {
  const auto s = GetParam().build();
  const auto nodes = s->hierarchy().nodes();
  std::vector<std::pair<std::uint32_t, int>> open{{0, 1}};
  while (!open.empty()) {
    const auto [index, depth] = open.back();
    open.pop_back();
    ASSERT_LE(depth, BoundingHierarchy::kMaxDepth);
    for (int i = 0; i < BoundingHierarchy::kWidth; ++i) {
      const auto& node = nodes[index];
      if (!node.child[i].isLeaf() && node.bounds[0][0][i] <= node.bounds[1][0][i])
        open.emplace_back(node.child[i].index(), depth + 1);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Hierarchy, testing::ValuesIn(manyShapes()));

TEST(HierarchyBudget, GivesTheBestOfWhatItMayLookAt) {
  const auto s = shapes::sphere(0.05, 30).build();
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> at(-0.06, 0.06);
  for (int i = 0; i < 300; ++i) {
    const Vec3 h{at(random), at(random), at(random)};
    double last = std::numeric_limits<double>::infinity();
    for (const int budget : {1, 8, 64, 512, 100000}) {
      int spent = 0;
      const ClosestPoint foot = s->closestFoot(h, budget, spent);
      EXPECT_LE(spent, budget);
      ASSERT_NE(foot.triangle, kNoTriangle);
      EXPECT_LE(foot.squaredDistance, last);
      last = foot.squaredDistance;
    }
  }
}

TEST(HierarchyBuild, IsTheSameWithTwoThreads) {
  const Shape shape = shapes::bumpy(0.05, 60);
  const auto one = shape.build(1);
  const auto two = shape.build(2);
  ASSERT_EQ(one->hierarchy().nodes().size(), two->hierarchy().nodes().size());
  EXPECT_TRUE(std::ranges::equal(std::as_bytes(one->hierarchy().nodes()), std::as_bytes(two->hierarchy().nodes())));
  for (std::uint32_t t = 0; t < one->triangleCount(); ++t) {
    ASSERT_EQ(one->canonical(t), two->canonical(t));
    ASSERT_EQ(one->triangle(t).flags, two->triangle(t).flags);
  }
}

}  // namespace
}  // namespace haptics::bounding_hierarchy_test

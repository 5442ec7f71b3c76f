#include "haptic_server/engine/geometry/neighbours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::neighbours_test {
namespace {

using shapes::Shape;

TEST(Neighbours, OfALineAreTwoPolygonsThatAgreeOnIt) {
  for (const Shape& shape : {shapes::box({1, 1, 1}, 2), shapes::torus(2, 1, 9, 7), shapes::bumpy(1, 5)}) {
    const auto s = shape.build();
    EXPECT_TRUE(s->closed());
    for (std::uint32_t t = 0; t < s->triangleCount(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t across = s->triangle(t).neighbour(k);
        const int same = sameLineAcross(*s, t, k);
        ASSERT_GE(same, 0);
        EXPECT_EQ(s->triangle(across).neighbour(same), t);
        EXPECT_EQ(s->triangle(across).corner(nextCorner(same)), s->triangle(t).corner(k));
        EXPECT_EQ(s->lineNormal(t, k), s->lineNormal(across, same));
      }
    }
  }
}

TEST(Neighbours, OfAVertexAreAllThatHaveIt) {
  for (const Shape& shape :
       {shapes::box({1, 1, 1}, 2), shapes::cone(1, 1, 17), shapes::bumpy(1, 5), shapes::sheet(1, 3)}) {
    const auto s = shape.build();
    std::vector<std::set<std::uint32_t>> around(shape.vertices.size());
    for (std::uint32_t t = 0; t < s->triangleCount(); ++t) {
      for (const std::uint32_t v : s->triangle(t).vertex) around[v].insert(t);
    }
    for (std::uint32_t t = 0; t < s->triangleCount(); ++t) {
      for (int k = 0; k < 3; ++k) {
        std::set<std::uint32_t> seen{t};
        visitFan(*s, t, k, [&](std::uint32_t other, int corner) {
          EXPECT_EQ(s->triangle(other).vertexAt(corner), s->triangle(t).vertexAt(k));
          EXPECT_TRUE(seen.insert(other).second) << "seen twice";
          return true;
        });
        EXPECT_EQ(seen, around[s->triangle(t).vertexAt(k)]);
      }
    }
  }
}

TEST(Neighbours, StopWhenTheVisitorHasSeenEnough) {
  const auto s = shapes::cone(1, 1, 100).build();
  int seen = 0;
  const auto apex = [&] {
    for (std::uint32_t t = 0;; ++t) {
      if (s->triangle(t).cornerOf(0) >= 0) return t;
    }
  }();
  visitFan(*s, apex, s->triangle(apex).cornerOf(0), [&](std::uint32_t, int) { return ++seen < 5; });
  EXPECT_EQ(seen, 5);
}

int boundaries(const CollisionMesh& s) {
  int count = 0;
  for (std::uint32_t t = 0; t < s.triangleCount(); ++t) {
    for (int k = 0; k < 3; ++k) count += s.triangle(t).neighbour(k) == kNoTriangle ? 1 : 0;
  }
  return count;
}

// S11 of the failure scenes: what real files hold.
TEST(Neighbours, StopAtHolesFinsDuplicatesAndFlippedFaces) {
  const Shape cube = shapes::box({1, 1, 1}, 3);
  EXPECT_EQ(boundaries(*cube.build()), 0);

  Shape hole = cube;
  hole.triangles.pop_back();
  EXPECT_EQ(boundaries(*hole.build()), 3);
  EXPECT_FALSE(hole.build()->closed());

  Shape flipped = cube;
  std::swap(flipped.triangles[5][0], flipped.triangles[5][1]);
  EXPECT_EQ(boundaries(*flipped.build()), 6);

  Shape duplicate = cube;
  duplicate.triangles.push_back(duplicate.triangles[7]);
  EXPECT_EQ(boundaries(*duplicate.build()), 9);  // three half edges on each of its three lines

  Shape fin = cube;
  fin.vertices.emplace_back(3, 3, 3);
  const auto tip = static_cast<std::uint32_t>(fin.vertices.size() - 1);
  fin.triangles.push_back({fin.triangles[0][0], fin.triangles[0][1], tip});
  EXPECT_EQ(boundaries(*fin.build()), 3 + 2);
}

TEST(Neighbours, DoNotDependOnTheOrderOfTheTriangles) {
  Shape shape = shapes::box({1, 1, 1}, 3);
  shape.triangles.push_back(shape.triangles[7]);
  const int expected = boundaries(*shape.build());
  std::mt19937_64 random(1);
  for (int i = 0; i < 20; ++i) {
    std::shuffle(shape.triangles.begin(), shape.triangles.end(), random);
    EXPECT_EQ(boundaries(*shape.build()), expected);
  }
}

TEST(Neighbours, MarkVerticesWherePartsTouchInAPoint) {
  Shape pair = shapes::box({1, 1, 1});
  pair.add(shapes::box({1, 1, 1}), Vec3(1));
  // Weld the one corner that the two cubes have in common.
  const auto at = [&](std::uint32_t from) {
    for (std::uint32_t v = from;; ++v) {
      if (pair.vertices[v] == Vec3f(0.5F)) return v;
    }
  };
  const std::uint32_t kept = at(0);
  const std::uint32_t dropped = at(kept + 1);
  for (auto& t : pair.triangles) std::replace(t.begin(), t.end(), dropped, kept);
  pair.vertices[dropped] = Vec3f(0);  // no longer used
  const auto s = pair.build();
  EXPECT_TRUE(s->closed());
  for (std::uint32_t t = 0; t < s->triangleCount(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_EQ(s->triangle(t).openAt(k), s->triangle(t).vertexAt(k) == kept);
  }
}

}  // namespace
}  // namespace haptics::neighbours_test

// Meshes of long triangles, whose boxes overlap: in cells.

#include "haptic_server/engine/geometry/long_triangles.h"

#include <gtest/gtest.h>

#include <random>

#include "common/deform/dent.h"
#include "haptic_server/engine/geometry/enclosure.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::long_triangles_test {
namespace {

class Places {
 public:
  Vec3 operator()(double reach = 0.05) { return reach * Vec3(part_(random_), part_(random_), part_(random_)); }

 private:
  std::mt19937_64 random_{11};
  std::uniform_real_distribution<double> part_{-1, 1};
};

shapes::Shape soupOf(int triangles) {
  Places place;
  shapes::Shape soup;
  for (int i = 0; i < triangles; ++i) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (int k = 0; k < 3; ++k) soup.vertices.emplace_back(place());
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

/// Closed, each of four long faces, turned outward.
shapes::Shape tetrahedra(int count) {
  Places place;
  shapes::Shape all;
  for (int i = 0; i < count; ++i) {
    std::array<Vec3, 4> corner{place(), place(), place(), place()};
    if (glm::dot(glm::cross(corner[1] - corner[0], corner[2] - corner[0]), corner[3] - corner[0]) > 0)
      std::swap(corner[1], corner[2]);
    const auto v = static_cast<std::uint32_t>(all.vertices.size());
    for (const Vec3 each : corner) all.vertices.emplace_back(each);
    for (const auto& t : {std::array{0U, 1U, 2U}, {0U, 3U, 1U}, {1U, 3U, 2U}, {2U, 3U, 0U}}) {
      all.triangles.push_back({v + t[0], v + t[1], v + t[2]});
    }
  }
  return all;
}

/// A fine sphere among them.
shapes::Shape mixed() {
  shapes::Shape all = shapes::sphere(0.02, 20);
  all.add(soupOf(300));
  return all;
}

void expectQueriesOfBruteForce(const CollisionMesh& surface) {
  Places place;
  for (int i = 0; i < 400; ++i) {
    const Vec3 from = place(), to = i % 2 == 0 ? place() : from + place(0.001);
    const Segment segment(from, to);
    double first = 1;
    bool any = false;
    ClosestPoint nearest;
    for (std::uint32_t t = 0; t < surface.triangleCount(); ++t) {
      Crossing crossing{t};
      if (segment.enters(surface.triangle(t), true, crossing)) {
        first = any ? std::min(first, crossing.time) : crossing.time;
        any = true;
      }
      const ClosestPoint foot = closestOn(surface.triangle(t), t, from);
      if (foot.squaredDistance < nearest.squaredDistance) nearest = foot;
    }
    Allowance endless;
    const Crossing found = surface.firstCrossing(from, to, true, endless, [](std::uint32_t) { return false; });
    ASSERT_EQ(static_cast<bool>(found), any) << i;
    if (any) {
      ASSERT_EQ(found.time, first) << i;
    }
    int spent = 0;
    ASSERT_EQ(surface.closestFoot(from, 1 << 20, spent).squaredDistance, nearest.squaredDistance) << i;
  }
}

TEST(LongTriangles, AreNoneInUsualMeshes) {
  for (const shapes::Shape& shape :
       {shapes::box(Vec3(0.1)), shapes::box(Vec3(0.1), 8), shapes::sphere(0.05, 4), shapes::sphere(0.05, 40),
        shapes::torus(0.04, 0.01, 40, 20), shapes::cone(0.05, 0.02, 4000), shapes::sheet(0.1, 30), soupOf(63)}) {
    EXPECT_FALSE(shape.build()->hierarchy().hasCells());
  }
}

TEST(LongTriangles, AreMetAsByBruteForce) {
  for (const shapes::Shape& shape : {soupOf(64), soupOf(500), mixed(), tetrahedra(100)}) {
    const auto surface = shape.build();
    ASSERT_TRUE(surface->hierarchy().hasCells());
    expectQueriesOfBruteForce(*surface);
  }
}

TEST(LongTriangles, CostAQueryAFractionOfTheirNumber) {
  const auto surface = soupOf(4000).build();
  Places place;
  std::int64_t units = 0;
  constexpr int kQueries = 200;
  for (int i = 0; i < kQueries; ++i) {
    const Vec3 from = place();
    Allowance allowance(1'000'000'000);
    (void)surface->firstCrossing(from, from + place(0.001), allowance);
    units += 1'000'000'000 - allowance.left();
  }
  EXPECT_LT(units / kQueries, 8'000) << "94,000 with a box about each";
}

TEST(LongTriangles, AreRefittedToWhereTheyHaveMoved) {
  shapes::Shape shape = mixed();
  const auto before = shape.build();
  shape = shape.mapped([](Vec3 v) { return Vec3(v.x + 0.3 * v.y, v.y - 0.2 * v.z, 0.9 * v.z); });
  const auto refitted = refitCollisionMesh(*before, shape.vertices);
  ASSERT_TRUE(refitted->hierarchy().hasCells());
  expectQueriesOfBruteForce(*refitted);
  const auto again = refitCollisionMesh(*refitted, shape.vertices);
  EXPECT_EQ(again->hierarchy().nodes().size(), refitted->hierarchy().nodes().size());
  CollisionMesh inPlace(*before);
  inPlace.moveVertices(shape.vertices);
  expectQueriesOfBruteForce(inPlace);
}

TEST(LongTriangles, MayCollapse) {
  const shapes::Shape shape = soupOf(100);
  const auto before = shape.build();
  const auto scaled = [&](Vec3 scale) {
    const auto collapsed = refitCollisionMesh(*before, shape.mapped([&](Vec3 v) { return scale * v; }).vertices);
    EXPECT_TRUE(collapsed->hierarchy().hasCells());
    expectQueriesOfBruteForce(*refitCollisionMesh(*collapsed, shape.vertices));
    return collapsed;
  };
  for (const Vec3 scale : {Vec3(0), Vec3(1, 0, 0), Vec3(0, 1, 1), Vec3(1, 1e-43, 0), Vec3(1e4), Vec3(1e4, 0, 1e-44)}) {
    SCOPED_TRACE(testing::Message() << scale.x << ' ' << scale.y << ' ' << scale.z);
    expectQueriesOfBruteForce(*scaled(scale));
  }
  for (const double scale :
       {1e-30, 1e-38, 1e-43}) {  // beside the segments' ends all corners are one: what they cross means nothing
    const auto collapsed = scaled(Vec3(scale));
    int spent = 0;
    EXPECT_NEAR(collapsed->closestFoot({0.03, 0, 0}, 1 << 20, spent).squaredDistance, 9e-4, 1e-12);
  }
}

/// Without any other triangle there is no hierarchy but that of the cells.
TEST(LongTriangles, AreDentedWhereThereIsNothingElse) {
  const Falloff falloff(0.03, 2);
  const Dent dent{.centre = {0.01F, 0, 0.02F}, .displacement = {0.001F, 0.002F, -0.008F}};
  for (const shapes::Shape& shape : {soupOf(500), tetrahedra(100)}) {
    const auto before = shape.build();
    ASSERT_TRUE(before->hierarchy().hasCells());
    ASSERT_EQ(before->hierarchy().firstInCells(), 0U);
    const shapes::Shape pressed = shape.mapped([&](Vec3 v) { return v + displacementBy(dent, falloff, v); });
    const auto dented = refitCollisionMesh(*before, pressed.vertices);
    ASSERT_TRUE(dented->hierarchy().hasCells());
    ASSERT_EQ(dented->hierarchy().firstInCells(), 0U);
    expectQueriesOfBruteForce(*dented);
    const auto back = refitCollisionMesh(*dented, shape.vertices);
    EXPECT_EQ(back->hierarchy().cellCount(), before->hierarchy().cellCount());
    expectQueriesOfBruteForce(*back);
  }
}

TEST(LongTriangles, AreCountedOnceByTheWindingNumber) {
  const auto surface = tetrahedra(100).build();
  ASSERT_TRUE(surface->closed());
  Places place;
  int inside = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 at = place();
    int around = 0;
    for (std::uint32_t t = 0; t < surface->triangleCount(); t += 1) {
      // Solid angle, of each face by itself.
      const TriangleRecord& r = surface->triangle(t);
      const Vec3 a = r.corner(0) - at, b = r.corner(1) - at, c = r.corner(2) - at;
      const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
      around += static_cast<int>(
          std::lround(1e6 *
                      std::atan2(glm::dot(a, glm::cross(b, c)),
                                 la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb) /
                      6.283185307179586));
    }
    Allowance endless;
    ASSERT_EQ(windingNumber(*surface, at, endless), std::lround(around / 1e6)) << i;
    inside += around > 0.5e6 ? 1 : 0;
  }
  EXPECT_GT(inside, 100);
}

TEST(LongTriangles, AreMarkedWhereTheyPassThroughEachOther) {
  for (const shapes::Shape& shape : {soupOf(80), mixed()}) {
    const auto surface = shape.build();
    const std::uint32_t count = surface->triangleCount();
    std::vector<bool> crossed(count, false);
    const auto shares = [&](const TriangleRecord& a, const TriangleRecord& b) {
      return a.cornerOf(b.vertexAt(0)) >= 0 || a.cornerOf(b.vertexAt(1)) >= 0 || a.cornerOf(b.vertexAt(2)) >= 0;
    };
    for (std::uint32_t t = 0; t < count; ++t) {
      for (int k = 0; k < 3; ++k) {
        const TriangleRecord& own = surface->triangle(t);
        const Segment line(own.corner(k), own.corner(nextCorner(k)));
        for (std::uint32_t other = 0; other < count; ++other) {
          Crossing crossing;
          if (other == t || shares(own, surface->triangle(other))) continue;
          if (!line.enters(surface->triangle(other), true, crossing)) continue;
          crossed[t] = crossed[other] = true;
          if (own.neighbour(k) != kNoTriangle) crossed[own.neighbour(k)] = true;
        }
      }
    }
    for (std::uint32_t t = 0; t < count; ++t) ASSERT_EQ(surface->triangle(t).selfIntersecting(), crossed[t]) << t;
  }
}

}  // namespace
}  // namespace haptics::long_triangles_test

#include "haptic_server/engine/geometry/collision_mesh.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>
#include <utility>

#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::collision_mesh_test {
namespace {

using shapes::Shape;

/// How often the mesh winds around p: 1 inside, 0 outside (van Oosterom and Strackee 1983). Independent of any closest
/// point.
double windingNumber(const Shape& shape, Vec3 p) {
  double angle = 0;
  for (std::size_t t = 0; t < shape.triangles.size(); ++t) {
    const Vec3 a = shape.corner(t, 0) - p;
    const Vec3 b = shape.corner(t, 1) - p;
    const Vec3 c = shape.corner(t, 2) - p;
    const double la = glm::length(a);
    const double lb = glm::length(b);
    const double lc = glm::length(c);
    angle += 2 * std::atan2(glm::dot(a, glm::cross(b, c)),
                            la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return angle / (4 * std::numbers::pi);
}

std::vector<bool> crossedTriangles(const CollisionMesh& surface) {
  std::vector<bool> crossed(surface.triangleCount());
  for (std::uint32_t t = 0; t < surface.triangleCount(); ++t) {
    crossed[surface.canonical(t)] = surface.triangle(t).selfIntersecting();
  }
  return crossed;
}

/// By number of the vertex.
std::vector<Vec3> vertexNormals(const CollisionMesh& surface) {
  std::vector<Vec3> normals(3 * std::size_t{surface.triangleCount()});
  for (std::uint32_t t = 0; t < surface.triangleCount(); ++t) {
    for (int k = 0; k < 3; ++k) normals[surface.triangle(t).vertexAt(k)] = surface.vertexNormal(t, k);
  }
  return normals;
}

/// A star of spikes: valence and angles vary widely, edges are acute inside and out.
Shape spiky(int n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> size(0.02, 0.06);
  return shapes::sphere(1, n).mapped([&](Vec3 v) { return v * size(random); });
}

/// 4,000 needles through one point: every pair crosses, 16 million crossings if each were looked for.
Shape heapOfNeedles() {
  Shape heap;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<float> at(-1, 1);
  for (std::uint32_t i = 0; i < 12'000; i += 3) {
    const Vec3f d(at(random), at(random), at(random));
    const Vec3f width = 0.01F * Vec3f(at(random), at(random), at(random));
    heap.vertices.insert(heap.vertices.end(), {d + width, d - width, -d});
    heap.triangles.push_back({i, i + 1, i + 2});
  }
  return heap;
}

class Sign : public testing::TestWithParam<Shape> {};

TEST_P(Sign, AtTheClosestPointTellsInsideFromOutside) {
  const Shape& shape = GetParam();
  const auto s = shape.build();
  ASSERT_TRUE(s->closed());
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> at(-0.07, 0.07);
  int inside = 0;
  for (int i = 0; i < 1500; ++i) {
    const Vec3 h{at(random), at(random), at(random)};
    const double winding = windingNumber(shape, h);
    ASSERT_TRUE(std::abs(winding) < 1e-6 || std::abs(winding - 1) < 1e-6);
    int spent = 0;
    EXPECT_EQ(s->isOutside(s->closestFoot(h, 1 << 20, spent), h), winding < 0.5);
    inside += winding > 0.5 ? 1 : 0;
  }
  EXPECT_GT(inside, 10);
}

INSTANTIATE_TEST_SUITE_P(ClosedShapes, Sign,
                         testing::Values(shapes::bumpy(0.05, 6), shapes::torus(0.05, 0.015, 24, 12),
                                         shapes::box({0.1, 0.06, 0.03}), shapes::cone(0.05, 0.06, 5),
                                         shapes::cone(0.05, 0.06, 64), spiky(3, 1), spiky(5, 2)));

TEST(CollisionMesh, NormalsAreThoseOfThePaper) {
  const Shape cube = shapes::box({2, 2, 2});
  const auto s = cube.build();
  const double third = 1 / std::sqrt(3.0);
  for (std::uint32_t t = 0; t < s->triangleCount(); ++t) {
    const Vec3 face = s->faceNormal(t);
    EXPECT_NEAR(glm::length(face), 1, 1e-12);
    for (int k = 0; k < 3; ++k) {
      const Vec3 corner = s->triangle(t).corner(k);
      EXPECT_NEAR(glm::dot(face, corner), 1, 1e-12);  // outwards
      // Weighted by the angle, the corner's normal does not depend on how its sides are cut into triangles.
      EXPECT_NEAR(glm::distance(s->vertexNormal(t, k), corner * third), 0, 1e-6);
      const Vec3 middle = (corner + s->triangle(t).corner(nextCorner(k))) * 0.5;
      EXPECT_NEAR(glm::distance(s->lineNormal(t, k), glm::normalize(middle)), 0, 1e-6) << "line " << k;
    }
  }
}

TEST(CollisionMesh, KnowsItsSize) {
  const auto s = shapes::box({0.2, 0.4, 0.4}).mapped([](Vec3 v) { return v + Vec3(0.1, 0, 0); }).build();
  EXPECT_NEAR(glm::distance(s->low(), Vec3(0, -0.2, -0.2)), 0, 1e-7);
  EXPECT_NEAR(glm::distance(s->high(), Vec3(0.2, 0.2, 0.2)), 0, 1e-7);
  EXPECT_NEAR(s->radius_m(), 0.3, 1e-7);
  EXPECT_NEAR(s->extent_m(), std::sqrt(0.12), 1e-7);
}

TEST(CollisionMesh, TakesAtMost95BytesATriangle) {
  for (int n = 8; n < 120; n += 7) {
    const auto torus = shapes::torus(0.05, 0.02, 2 * n, n).build();
    EXPECT_LE(torus->memory_bytes(), 95U * torus->triangleCount()) << torus->triangleCount();
    const auto box = shapes::box({0.1, 0.05, 0.02}, n).build();
    EXPECT_LE(box->memory_bytes(), 95U * box->triangleCount()) << box->triangleCount();
  }
}

TEST(CollisionMesh, MarksPartsThatPassThroughEachOther) {
  Shape apart = shapes::box({1, 1, 1}, 2);
  apart.add(shapes::box({1, 1, 1}, 2), Vec3(1.5, 0, 0));
  EXPECT_FALSE(apart.build()->anySelfIntersecting());
  for (const Shape& embedded : {shapes::torus(1, 0.4, 30, 20), shapes::bumpy(1, 12), shapes::cone(1, 1, 4096)}) {
    EXPECT_FALSE(embedded.build()->anySelfIntersecting());
  }

  Shape crossed = shapes::box({1, 1, 1}, 4);
  crossed.add(shapes::box({1, 1, 1}, 4), Vec3(0.6, 0.3, 0.2));
  const auto s = crossed.build();
  ASSERT_TRUE(s->anySelfIntersecting());
  for (std::uint32_t t = 0; t < s->triangleCount(); ++t) {
    // A triangle of the second box that lies across the first one's right side is marked, one far from it is not.
    const Vec3 middle = (s->triangle(t).corner(0) + s->triangle(t).corner(1) + s->triangle(t).corner(2)) / 3.0;
    if (middle.x < 0 || middle.x > 0.9) {
      EXPECT_FALSE(s->triangle(t).selfIntersecting());
    }
  }
}

TEST(CollisionMesh, TakesAHeapOfCrossingNeedlesForCrossedAsAWholeInBoundedTime) {
  const auto s = heapOfNeedles().build();
  EXPECT_TRUE(s->anySelfIntersecting());
  for (std::uint32_t t = 0; t < s->triangleCount(); ++t) ASSERT_TRUE(s->triangle(t).selfIntersecting());
}

TEST(CollisionMesh, GivesAFaceWithoutAreaTheNormalBesideIt) {
  // The unit square in two triangles, one of them cut at the middle of an edge that the other does not know: a face
  // without area fills the joint.
  const Shape square{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5F, 0.5F, 0}},
                     {{0, 1, 2}, {0, 4, 3}, {4, 2, 3}, {0, 2, 4}}};
  const auto s = square.build();
  int flat = 0;
  for (std::uint32_t t = 0; t < s->triangleCount(); ++t) {
    flat += s->triangle(t).zeroArea() ? 1 : 0;
    EXPECT_EQ(s->faceNormal(t), Vec3(0, 0, 1));
  }
  EXPECT_EQ(flat, 1);
  for (std::uint32_t t = 0; t < s->triangleCount(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_EQ(s->vertexNormal(t, k), Vec3(0, 0, 1));
  }
}

TEST(CollisionMesh, HoldsAFineMeshInFewBytesATriangle) {
  const auto s = shapes::sphere(0.05, 73).build();
  const double each = static_cast<double>(s->memory_bytes()) / s->triangleCount();
  EXPECT_GT(each, sizeof(TriangleRecord) + 4 + 6);  // its canonical number, the normal of half a vertex
  EXPECT_LE(each, 95);
}

TEST(CollisionMesh, BuildsWhateverSatisfiesTheMeshsInvariants) {
  const Shape one{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const Shape speck{{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}}};
  const Shape pillow{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}};
  const Shape vast = shapes::box(Vec3(1e37), 2);
  const Shape tiny = shapes::box(Vec3(1e-37), 2);
  Shape same;
  for (int i = 0; i < 3000; ++i) same.add(one);
  for (const Shape& shape : {one, speck, pillow, vast, tiny, same}) {
    const auto s = shape.build();
    EXPECT_EQ(s->triangleCount(), shape.triangles.size());
    int spent = 0;
    EXPECT_NE(s->closestFoot(s->centre(), 1000, spent).triangle, kNoTriangle);
    (void)s->firstCrossing(s->low() - Vec3(1), s->high() + Vec3(1));
  }
  EXPECT_TRUE(pillow.build()->closed());
}

TEST(CollisionMesh, RefittedAnswersAsOneBuiltAnew) {
  const Shape rest = shapes::sphere(0.05, 12);
  const Shape bent = rest.mapped([](Vec3 v) { return Vec3(v.x + 8 * v.z * v.z, 1.3 * v.y, v.z - 5 * v.x * v.y); });
  const auto refitted = refitCollisionMesh(*rest.build(), bent.vertices);
  CollisionMesh inPlace(*rest.build());
  inPlace.moveVertices(bent.vertices);
  const auto anew = bent.build();
  for (const CollisionMesh* const moved : {refitted.get(), &std::as_const(inPlace)}) {
    EXPECT_EQ(moved->closed(), anew->closed());
    EXPECT_EQ(moved->extent_m(), anew->extent_m());
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> at(-0.08, 0.08);
    for (int i = 0; i < 2000; ++i) {
      const Vec3 from(at(random), at(random), at(random));
      const Vec3 to(at(random), at(random), at(random));
      int spent = 0;
      const ClosestPoint a = moved->closestFoot(from, 1 << 20, spent);
      const ClosestPoint b = anew->closestFoot(from, 1 << 20, spent);
      ASSERT_EQ(a.squaredDistance, b.squaredDistance);
      ASSERT_EQ(moved->isOutside(a, from), anew->isOutside(b, from));
      ASSERT_LT(glm::distance(moved->normal(a), anew->normal(b)), 1e-6);
      const Crossing c = moved->firstCrossing(from, to);
      const Crossing d = anew->firstCrossing(from, to);
      ASSERT_EQ(bool(c), bool(d));
      if (c) {
        ASSERT_NEAR(c.time, d.time, 1e-12);
      }
    }
  }
}

TEST(CollisionMesh, RefittedMarksWhatHasComeToCross) {
  // A bar rolled up about y by more than a turn: its end passes into its beginning.
  const Shape straight = shapes::box({0.4, 0.03, 0.03}, 12);
  const auto rolled = [&](double turns) {
    const double radius_m = 0.4 / (2 * std::numbers::pi * turns);
    return straight.mapped([=](Vec3 v) {
      const double angle = v.x / radius_m;
      return Vec3((radius_m + v.z) * std::sin(angle), v.y, (radius_m + v.z) * std::cos(angle));
    });
  };
  const auto rest = straight.build();
  const auto open = refitCollisionMesh(*rest, rolled(0.9).vertices);
  EXPECT_FALSE(open->anySelfIntersecting());
  const auto anew = rolled(1.1).build();
  ASSERT_TRUE(anew->anySelfIntersecting());
  for (const auto& from : {rest, open}) {
    const auto crossed = refitCollisionMesh(*from, rolled(1.1).vertices);
    EXPECT_TRUE(crossed->anySelfIntersecting());
    EXPECT_EQ(crossedTriangles(*crossed), crossedTriangles(*anew));
    const auto unrolled = refitCollisionMesh(*crossed, straight.vertices);
    EXPECT_FALSE(unrolled->anySelfIntersecting());
    EXPECT_EQ(crossedTriangles(*unrolled), std::vector<bool>(straight.triangles.size()));
  }
}

TEST(CollisionMesh, RefittedAgainAndAgainMarksWhatOneBuiltAnewDoes) {
  // Two balls close to each other; bumps and dents move some of their vertices, others go back to where they were.
  Shape rest = shapes::sphere(0.05, 8);
  rest.add(shapes::sphere(0.05, 8), Vec3(0.08, 0.003, 0.001));
  for (const Vec3 gap : {Vec3(0), Vec3(0.025, 0, 0)}) {
    Shape now = rest;
    for (std::size_t i = rest.vertices.size() / 2; i < rest.vertices.size(); ++i) now.vertices[i] += Vec3f(gap);
    const Shape start = now;
    std::shared_ptr<const CollisionMesh> surface = start.build();
    std::mt19937_64 random(11);
    std::uniform_int_distribution<std::size_t> which(0, rest.vertices.size() - 1);
    std::normal_distribution<double> way(0, 0.02);
    int changes = 0;
    for (int i = 0; i < 150; ++i) {
      const Vec3 centre(now.vertices[which(random)]);
      const Vec3 displacement = Vec3(way(random), way(random), way(random));
      for (std::size_t v = 0; v < now.vertices.size(); ++v) {
        const double part = 1 - glm::distance(Vec3(now.vertices[v]), centre) / 0.02;
        if (part <= 0) continue;
        now.vertices[v] = i % 3 == 0 ? start.vertices[v] : now.vertices[v] + Vec3f(displacement * part);
      }
      const std::vector<bool> before = crossedTriangles(*surface);
      surface = refitCollisionMesh(*surface, now.vertices);
      const auto anew = now.build();
      ASSERT_EQ(surface->anySelfIntersecting(), anew->anySelfIntersecting());
      ASSERT_EQ(crossedTriangles(*surface), crossedTriangles(*anew)) << i;
      const std::vector<Vec3> normals = vertexNormals(*surface), expected = vertexNormals(*anew);
      for (std::size_t v = 0; v < normals.size(); ++v) ASSERT_LT(glm::distance(normals[v], expected[v]), 1e-6) << i;
      changes += crossedTriangles(*surface) != before ? 1 : 0;
    }
    EXPECT_GT(changes, 50);
    surface = refitCollisionMesh(*surface, start.vertices);
    EXPECT_EQ(crossedTriangles(*surface), crossedTriangles(*start.build()));
    EXPECT_EQ(surface->anySelfIntersecting(), gap == Vec3(0));
  }
}

TEST(CollisionMesh, RefittedToAHeapOfCrossingNeedlesIsTakenForCrossedAsAWholeUntilTheyAreApart) {
  const Shape heap = heapOfNeedles();
  Shape apart = heap;
  for (std::size_t i = 0; i < apart.vertices.size(); ++i) apart.vertices[i].x += 3 * static_cast<float>(i / 3);
  const auto refitted = refitCollisionMesh(*apart.build(), heap.vertices);
  EXPECT_EQ(crossedTriangles(*refitted), std::vector<bool>(heap.triangles.size(), true));
  EXPECT_FALSE(refitCollisionMesh(*refitted, apart.vertices)->anySelfIntersecting());
}

}  // namespace
}  // namespace haptics::collision_mesh_test

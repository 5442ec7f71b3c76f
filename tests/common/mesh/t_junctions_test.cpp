#include "common/mesh/t_junctions.h"

#include <gtest/gtest.h>

#include <random>

#include "common/mesh/import.h"

namespace haptics::t_junctions_test {
namespace {

/// The triangle 0 0 0, 1 0 0, 0 1 0 over one edge, and two triangles below it that meet at `middle` on that edge.
std::vector<Vec3> overEdgeAnd(Vec3 middle) { return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, -1, 0}, middle}; }
const std::vector<TriangleIndices> kOneOverTwo{{0, 1, 2}, {0, 3, 4}, {4, 3, 1}};

std::uint64_t tJunctions(const std::vector<Vec3>& vertices, const std::vector<TriangleIndices>& triangles) {
  return canonicalise(vertices, triangles, {}).value().report.tJunctions;
}

TEST(TJunctions, AreVerticesWithinABoundaryEdge) {
  EXPECT_EQ(tJunctions(overEdgeAnd({0.3, 0, 0}), kOneOverTwo), 1U);
  EXPECT_EQ(tJunctions(overEdgeAnd({0.3, 1e-7, 0}), kOneOverTwo), 1U) << "rounding of a float coordinate";
  EXPECT_EQ(tJunctions(overEdgeAnd({0.3, -1e-4, 0}), kOneOverTwo), 0U)
      << "a crack, but none that can be told from a gap";
  EXPECT_EQ(tJunctions(overEdgeAnd({0.3, 0, 0}), {{0, 1, 2}}), 0U) << "the vertex is not used";
}

TEST(TJunctions, AreNoneOnAClosedOrAWellKnitOpenMesh) {
  std::vector<Vec3> vertices;
  std::vector<TriangleIndices> triangles;
  constexpr std::uint32_t kSide = 20;
  for (std::uint32_t i = 0; i <= kSide; ++i) {
    for (std::uint32_t j = 0; j <= kSide; ++j) vertices.emplace_back(0.01 * i, 0.013 * j, 0);
  }
  for (std::uint32_t i = 0; i < kSide; ++i) {
    for (std::uint32_t j = 0; j < kSide; ++j) {
      const std::uint32_t v = i * (kSide + 1) + j;
      triangles.push_back({v, v + kSide + 1, v + kSide + 2});
      triangles.push_back({v, v + kSide + 2, v + 1});
    }
  }
  EXPECT_EQ(tJunctions(vertices, triangles), 0U);
}

TEST(TJunctions, DoNotDependOnTheUnit) {
  for (const double unit_m : {1e-6, 1e-3, 0x1p-10, 1e3}) {
    const auto imported = canonicalise(overEdgeAnd({0.3, 0, 0}), kOneOverTwo, {.unit_m = unit_m});
    EXPECT_EQ(imported.value().report.tJunctions, 1U) << unit_m;
  }
}

/// Edges of very different lengths, in every direction, against the definition.
TEST(TJunctions, AreThoseOfBruteForce) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> at(-1, 1), part(0.1, 0.9), power(-8, 0);
  std::vector<Vec3f> vertices;
  std::vector<EdgeIndices> boundary;
  const auto add = [&](Vec3 a, Vec3 b) {
    const auto first = static_cast<std::uint32_t>(vertices.size());
    vertices.insert(vertices.end(), {Vec3f(a), Vec3f(b)});
    boundary.push_back({first, first + 1});
  };
  std::uint64_t expected = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 a(at(random), at(random), at(random));
    const Vec3 b = a + std::exp2(power(random)) * glm::normalize(Vec3(at(random), at(random), at(random)));
    add(a, b);
    if (i % 3 != 0) continue;
    const Vec3 on = glm::mix(a, b, part(random));
    add(on, on + Vec3(at(random), at(random), at(random)) * 0.01);
    ++expected;
  }
  Work work = tJunctionAllowance(boundary.size());
  EXPECT_EQ(countTJunctions(vertices, boundary, work), expected);
}

/// From one small place to another: each edge passes all ends, and meets none.
TEST(TJunctions, AreNotSearchedForever) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<float> small(0, 1e-4F);
  std::vector<Vec3f> vertices;
  std::vector<EdgeIndices> boundary;
  for (std::uint32_t i = 0; i < 60'000; i += 3) {
    for (const float x : {0.0F, 0.5F, 1.0F}) vertices.emplace_back(x, small(random), small(random));
    boundary.insert(boundary.end(), {{i, i + 1}, {i, i + 2}});
  }
  Work work = tJunctionAllowance(boundary.size());
  EXPECT_FALSE(countTJunctions(vertices, boundary, work));
  EXPECT_GT(work.left(), -1000) << "ends when the work is over";
}

}  // namespace
}  // namespace haptics::t_junctions_test

#include "common/mesh/self_intersection_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "common/mesh/generators.h"

namespace haptics::crossings_test {
namespace {

TriMesh fromTriangles(const std::vector<std::array<Vec3f, 3>>& triangles) {
  TriMesh mesh;
  for (const auto& corners : triangles) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), corners.begin(), corners.end());
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

std::size_t selfIntersectionsOf(const TriMesh& mesh) {
  Work work = SelfIntersectionSearch::allowance(mesh);
  return SelfIntersectionSearch(mesh).all(work).value().size();
}

const std::array<Vec3f, 3> kFloor{Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(0, 1, 0)};

TEST(SelfIntersectionSearch, AreTrianglesThatASideOfAnotherPierces) {
  const auto withFloor = [](Vec3f a, Vec3f b, Vec3f c) {
    return selfIntersectionsOf(fromTriangles({kFloor, {a, b, c}}));
  };
  EXPECT_EQ(withFloor({0.2F, 0.2F, -1}, {0.2F, 0.2F, 1}, {3, 3, 1}), 1U);
  EXPECT_EQ(withFloor({-1, 0.3F, -1}, {-1, 0.3F, 1}, {3, 0.3F, 0}), 1U) << "only the floor's sides pierce the other";
  EXPECT_EQ(withFloor({0.2F, 0.2F, 0.1F}, {0.2F, 0.2F, 1}, {3, 3, 1}), 0U) << "above";
  EXPECT_EQ(withFloor({2, 2, -1}, {2, 2, 1}, {3, 3, 1}), 0U) << "beside";
  EXPECT_EQ(withFloor({0.5F, 0, 0}, {1, 1, 0}, {0, 0.4F, 0}), 0U) << "in one plane";
}

TEST(SelfIntersectionSearch, AreNoneWhereTrianglesShareTheVertex) {
  TriMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3F, 0.3F, -1}, {0.3F, 0.3F, 1}}, {{0, 1, 2}, {0, 3, 4}}};
  EXPECT_EQ(selfIntersectionsOf(mesh), 1U) << "the side that is opposite to the common vertex";
  mesh.vertices[3] = {-1, 0.3F, -1};
  EXPECT_EQ(selfIntersectionsOf(mesh), 0U);
  EXPECT_EQ(selfIntersectionsOf(makeSphere(0.05, 16).value()), 0U);
}

TEST(SelfIntersectionSearch, AreFoundAsByTryingAllPairs) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<float> place(0, 1), size(-0.1F, 0.1F);
  for (const int count : {1, 2, 8, 9, 63, 300}) {
    std::vector<std::array<Vec3f, 3>> triangles(static_cast<std::size_t>(count));
    for (auto& corners : triangles) {
      const Vec3f middle(place(random), place(random), place(random));
      for (Vec3f& corner : corners) corner = middle + Vec3f(size(random), size(random), size(random));
    }
    const TriMesh mesh = fromTriangles(triangles);
    const SelfIntersectionSearch search(mesh);
    std::set<std::array<std::uint32_t, 2>> expected;
    std::set<std::array<std::uint32_t, 2>> found;
    Work work = SelfIntersectionSearch::allowance(mesh);
    const auto pairs = search.all(work).value();
    for (auto [a, b] : pairs) EXPECT_TRUE(found.insert({std::min(a, b), std::max(a, b)}).second);
    for (std::uint32_t a = 0; a < triangles.size(); ++a) {
      for (std::uint32_t b = a + 1; b < triangles.size(); ++b) {
        if (selfIntersectionsOf(fromTriangles({triangles[a], triangles[b]})) > 0) expected.insert({a, b});
      }
      const std::array one{a};
      EXPECT_EQ(search.any(one, work),
                std::ranges::any_of(found, [a](const auto& p) { return p[0] == a || p[1] == a; }));
    }
    EXPECT_EQ(found, expected);
    EXPECT_EQ(found.empty(), count < 63);
  }
}

TEST(SelfIntersectionSearch, FollowVerticesThatMove) {
  TriMesh mesh = fromTriangles({kFloor, {Vec3f(0.2F, 0.2F, 1), Vec3f(0.2F, 0.2F, 2), Vec3f(3, 3, 2)}});
  SelfIntersectionSearch search(mesh);
  Work work = SelfIntersectionSearch::allowance(mesh);
  EXPECT_TRUE(search.all(work)->empty());
  mesh.vertices[3].z = -1;
  search.refit(std::array{1U});
  EXPECT_EQ(search.all(work)->size(), 1U);
  const std::array floor{0U};
  EXPECT_TRUE(search.any(floor, work));
}

TEST(SelfIntersectionSearch, AreNotSearchedForever) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<float> place(0, 1);
  std::vector<std::array<Vec3f, 3>> slivers(60'000);
  for (auto& corners : slivers) {
    const Vec3f at(place(random), place(random), 0);
    corners = {at, at + Vec3f(1e-6F, 0, 0), Vec3f(place(random), place(random), 1)};
  }
  const TriMesh mesh = fromTriangles(slivers);
  Work work = SelfIntersectionSearch::allowance(mesh);
  EXPECT_FALSE(SelfIntersectionSearch(mesh).all(work).has_value());
  EXPECT_GT(work.left(), -10'000) << "ends when the work is over";
  EXPECT_TRUE(SelfIntersectionSearch(mesh).any(std::array{0U}, work)) << "not known";
}

TEST(SelfIntersectionSearch, TakeWorkInProportionToTheTriangles) {
  for (const int n : {10, 20, 40, 80}) {
    const TriMesh mesh = makeSphere(0.05, n).value();
    Work work = SelfIntersectionSearch::allowance(mesh);
    const std::int64_t before = work.left();
    EXPECT_TRUE(SelfIntersectionSearch(mesh).all(work));
    EXPECT_LT(before - work.left(), 200 * static_cast<std::int64_t>(mesh.triangles.size())) << n;
  }
}

}  // namespace
}  // namespace haptics::crossings_test

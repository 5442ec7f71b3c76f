#include "haptic_server/engine/contact/neighborhood_watch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "common/mesh/import.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::neighborhood_watch_test {
namespace {

using shapes::Shape;

SearchResult search(const CollisionMesh& s, std::uint32_t start, Vec3 h) {
  SearchRun run;
  return neighborhoodWatch(s, start, h, run);
}

double bruteDistance(const CollisionMesh& s, Vec3 h) {
  double best = std::numeric_limits<double>::infinity();
  for (std::uint32_t t = 0; t < s.triangleCount(); ++t) {
    best = std::min(best, closestOn(s.triangle(t), t, h).squaredDistance);
  }
  return std::sqrt(best);
}

bool faces(const CollisionMesh& s, std::uint32_t t, Vec3 h) {
  return glm::dot(s.faceNormal(t), h - s.triangle(t).corner(0)) > 0;
}

class NeighborhoodWatch : public testing::Test {
 protected:
  Vec3 point(double size) {
    std::uniform_real_distribution<double> at(-size, size);
    return {at(random_), at(random_), at(random_)};
  }
  std::uint32_t any(const CollisionMesh& s) {
    return std::uniform_int_distribution<std::uint32_t>(0, s.triangleCount() - 1)(random_);
  }
  std::mt19937_64 random_{1};
};

// The printed algorithm stays on its first polygon (README.md, 2.1).
TEST_F(NeighborhoodWatch, LeavesTheFirstPolygon) {
  const auto s = shapes::box({0.1, 0.1, 0.1}, 10).build();
  const Vec3 h{0.033, 0.021, 0.06};
  for (std::uint32_t start = 0; start < s->triangleCount(); ++start) {
    if (!faces(*s, start, h)) continue;  // from the far side its own nearest point is a minimum too
    const SearchResult found = search(*s, start, h);
    EXPECT_TRUE(found.converged);
    EXPECT_NEAR(glm::distance(found.foot.point, Vec3(0.033, 0.021, 0.05)), 0, 1e-8) << "from " << start;
  }
}

/// ablatedWatch() has no short cut.
TEST_F(NeighborhoodWatch, WalkAcrossLinesGivesTheBitsOfTheGeneralSearch) {
  for (const Shape& shape : {shapes::sphere(0.05, 20), shapes::bumpy(0.05, 16), shapes::box({0.1, 0.06, 0.03}, 5),
                             shapes::sheet(0.1, 10), shapes::cone(0.05, 0.06, 40)}) {
    const auto s = shape.build();
    std::uint32_t start = 0;
    Vec3 h = s->triangle(0).corner(0);
    for (int i = 0; i < 20'000; ++i) {
      h = i % 100 == 0 ? point(0.06) : h + point(0.002);
      SearchPath path;
      SearchPath expectedPath;
      SearchRun run{.looked = i % 7 * 80, .path = &path};
      SearchRun expectedRun{.looked = run.looked, .path = &expectedPath};
      const SearchResult found = neighborhoodWatch(*s, start, h, run);
      const SearchResult expected = ablatedWatch(*s, start, h, expectedRun, kAllCorrections);
      ASSERT_EQ(found.foot.triangle, expected.foot.triangle) << i;
      ASSERT_EQ(found.foot.feature, expected.foot.feature) << i;
      ASSERT_EQ(found.foot.index, expected.foot.index) << i;
      ASSERT_EQ(found.foot.point, expected.foot.point) << i;
      ASSERT_EQ(found.foot.squaredDistance, expected.foot.squaredDistance) << i;
      ASSERT_EQ(found.converged, expected.converged) << i;
      ASSERT_EQ(run.looked, expectedRun.looked) << i;
      ASSERT_EQ(path.size(), expectedPath.size()) << i;
      ASSERT_TRUE(!path.complete() || std::equal(path.begin(), path.end(), expectedPath.begin(),
                                                 [](const SearchPath::Point& a, const SearchPath::Point& b) {
                                                   return a.place == b.place && a.triangle == b.triangle;
                                                 }))
          << i;
      start = found.foot.triangle;
    }
  }
}

TEST_F(NeighborhoodWatch, FindsTheGlobalMinimumOnConvexMeshes) {
  for (const Shape& shape :
       {shapes::box({0.1, 0.06, 0.03}, 5), shapes::cone(0.05, 0.06, 12),
        shapes::box({0.05, 0.05, 0.05}).mapped([](Vec3 v) { return v + 0.3 * Vec3(v.y, v.z, v.x); })}) {
    const auto s = shape.build();
    int outside = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 h = point(0.1);
      int spent = 0;
      if (!s->isOutside(s->closestFoot(h, 1 << 20, spent), h)) continue;
      std::uint32_t start = any(*s);
      while (!faces(*s, start, h)) start = any(*s);
      ++outside;
      const SearchResult found = search(*s, start, h);
      ASSERT_TRUE(found.converged);
      EXPECT_NEAR(std::sqrt(found.foot.squaredDistance), bruteDistance(*s, h), 1e-12);
    }
    EXPECT_GT(outside, 500);
  }
}

/// No triangle that touches the foot is closer: the local optimality that the god-object satisfies too.
void expectLocalMinimum(const CollisionMesh& s, const ClosestPoint& foot, Vec3 h) {
  for (std::uint32_t t = 0; t < s.triangleCount(); ++t) {
    if (closestOn(s.triangle(t), t, foot.point).squaredDistance > 1e-24) continue;
    const double there = closestOn(s.triangle(t), t, h).squaredDistance;
    ASSERT_GE(there, foot.squaredDistance * (1 - 1e-9)) << "triangle " << t;
  }
}

TEST_F(NeighborhoodWatch, EndsAtALocalMinimum) {
  Shape spikes = shapes::sphere(1, 6);
  std::uniform_real_distribution<double> size(0.03, 0.05);
  spikes = spikes.mapped([&](Vec3 v) { return v * size(random_); });
  for (const Shape& shape : {shapes::bumpy(0.05, 12), spikes, shapes::torus(0.04, 0.015, 30, 16)}) {
    const auto s = shape.build();
    for (int i = 0; i < 500; ++i) {
      const Vec3 h = point(0.05);
      const SearchResult found = search(*s, any(*s), h);
      ASSERT_TRUE(found.converged);
      expectLocalMinimum(*s, found.foot, h);
    }
  }
}

TEST_F(NeighborhoodWatch, PathStaysOnTheSurfaceAndDistanceDecreases) {
  const auto s = shapes::bumpy(0.05, 12).build();
  for (int i = 0; i < 500; ++i) {
    const Vec3 h = point(0.05);
    SearchPath path;
    SearchRun run{.path = &path};
    const std::uint32_t start = any(*s);
    const ClosestPoint foot = neighborhoodWatch(*s, start, h, run).foot;
    if (!path.complete()) continue;
    Vec3 last = path.begin()->place;
    double distance = std::numeric_limits<double>::infinity();
    for (const SearchPath::Point& p : path) {
      EXPECT_LT(closestOn(s->triangle(p.triangle), p.triangle, last).squaredDistance, 1e-28) << "a gap";
      EXPECT_LT(closestOn(s->triangle(p.triangle), p.triangle, p.place).squaredDistance, 1e-28);
      EXPECT_LT(glm::distance(p.place, h), distance + 1e-15);
      distance = glm::distance(p.place, h);
      last = p.place;
    }
    EXPECT_EQ(last, foot.point);
  }
}

TEST_F(NeighborhoodWatch, ResultIsIndependentOfTriangleOrder) {
  Shape shape = shapes::box({0.1, 0.06, 0.03}, 3);
  const auto s = shape.build();
  std::vector<Vec3> places;
  std::vector<Vec3> feet;
  for (int i = 0; i < 200; ++i) {
    places.push_back(Vec3(0, 0, 0.03) + point(0.02));
    feet.push_back(search(*s, 0, places.back()).foot.point);
  }
  for (int turn = 0; turn < 3; ++turn) {
    std::shuffle(shape.triangles.begin(), shape.triangles.end(), random_);
    for (auto& t : shape.triangles) std::rotate(t.begin(), t.begin() + 1, t.end());
    const auto other = shape.build();
    for (std::size_t i = 0; i < places.size(); ++i) {
      EXPECT_NEAR(glm::distance(search(*other, 0, places[i]).foot.point, feet[i]), 0, 1e-12);
    }
  }
}

static_assert(kCrowdedValence == kSearchBudget, "what an import reports is what a tick cannot look at");

// S6 of the failure scenes.
TEST_F(NeighborhoodWatch, BudgetedFanSearchConvergesOverTicks) {
  for (const int valence : {8, 300, 600, 4096}) {
    const auto s = shapes::cone(0.05, 0.03, valence).build();
    for (int i = 0; i < 30; ++i) {
      const double angle = 0.1 + 0.2 * i;
      const Vec3 h{0.02 * std::cos(angle), 0.02 * std::sin(angle), 0.03};
      std::uint32_t at = 0;
      while (s->triangle(at).cornerOf(0) < 0) ++at;
      double distance = std::numeric_limits<double>::infinity();
      SearchResult found;
      int calls = 0;
      do {
        SearchRun run;
        found = neighborhoodWatch(*s, at, h, run);
        EXPECT_LE(run.looked, kSearchBudget);
        EXPECT_LE(found.foot.squaredDistance, distance);
        distance = found.foot.squaredDistance;
        at = found.foot.triangle;
      } while (!found.converged && ++calls < 100);
      EXPECT_LE(calls, 2 * valence / kSearchBudget + 1);
      EXPECT_NEAR(std::sqrt(distance), bruteDistance(*s, h), 1e-12) << valence;
    }
  }
}

TEST_F(NeighborhoodWatch, CrossesZeroAreaFaces) {
  // Two sheets side by side whose common line has points that only one of them knows; flat faces fill the joint.
  Shape shape;
  shape.vertices = {{0, -1, 0}, {1, -1, 0}, {1, 0, 0}, {0, 0, 0}, {0.3F, 0, 0}, {0.6F, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  shape.triangles = {{0, 1, 2}, {0, 2, 3}, {2, 5, 3}, {5, 4, 3}, {3, 4, 6}, {4, 5, 6}, {5, 7, 6}, {5, 2, 7}};
  const auto s = shape.build();
  for (std::uint32_t start = 0; start < s->triangleCount(); ++start) {
    for (const Vec3 h : {Vec3(0.45, 0.3, -0.1), Vec3(0.45, -0.3, -0.1), Vec3(0.1, 0.05, -0.1), Vec3(0.9, -0.05, 0.1)}) {
      const SearchResult found = search(*s, start, h);
      EXPECT_TRUE(found.converged);
      EXPECT_NEAR(glm::distance(found.foot.point, Vec3(h.x, h.y, 0)), 0, 1e-6) << start << ": " << h.x << ", " << h.y;
    }
  }
}

}  // namespace
}  // namespace haptics::neighborhood_watch_test

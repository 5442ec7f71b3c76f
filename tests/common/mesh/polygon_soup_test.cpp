#include "common/mesh/polygon_soup.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

namespace haptics::polygon_soup_test {
namespace {

/// A soup with the polygon's corners as its vertices, cut.
PolygonSoup cut(std::vector<Vec3> outline) {
  PolygonSoup soup;
  soup.vertices = std::move(outline);
  std::vector<std::uint32_t> corners(soup.vertices.size());
  std::iota(corners.begin(), corners.end(), 0U);
  soup.addPolygon(corners);
  return soup;
}

Vec3 areaVector(const PolygonSoup& soup, const TriangleIndices& t) {
  const Vec3 a = soup.vertices[t[0]];
  return glm::cross(soup.vertices[t[1]] - a, soup.vertices[t[2]] - a) / 2.0;
}

TEST(Polygon, ThatIsConvexIsCutAsAFanFromItsFirstCorner) {
  const PolygonSoup soup = cut({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  EXPECT_EQ(soup.triangles, (std::vector<TriangleIndices>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(soup.polygonsTriangulated, 1U);
}

TEST(Polygon, ThatIsNotConvexIsCutWithoutOverlapInEveryPlaneAndFromEveryCorner) {
  // An arrow head, a comb and a star, so that fans would fold over themselves.
  std::vector<std::vector<Vec3>> outlines{{{0, 0, 0}, {2, -2, 0}, {0, 3, 0}, {-2, -2, 0}},
                                          {{0, 0, 0},
                                           {7, 0, 0},
                                           {7, 3, 0},
                                           {6, 3, 0},
                                           {6, 1, 0},
                                           {4, 1, 0},
                                           {4, 3, 0},
                                           {3, 3, 0},
                                           {3, 1, 0},
                                           {1, 1, 0},
                                           {1, 3, 0},
                                           {0, 3, 0}}};
  std::vector<Vec3> star;
  for (int i = 0; i < 20; ++i) {
    const double angle = std::numbers::pi * i / 10, r = i % 2 == 0 ? 1 : 0.2;
    star.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
  }
  outlines.push_back(star);
  for (const auto& outline : outlines) {
    for (int plane = 0; plane < 3; ++plane) {
      for (const double side : {1.0, -1.0}) {
        for (std::size_t first = 0; first < outline.size(); ++first) {
          std::vector<Vec3> turned;
          for (std::size_t i = 0; i < outline.size(); ++i) {
            const Vec3 p = outline[(first + i) % outline.size()];
            Vec3 q(0.3 * p.x + 0.1 * p.y);  // a slanted plane
            q[(plane + 1) % 3] = p.x;
            q[(plane + 2) % 3] = side * p.y;
            turned.push_back(q);
          }
          const PolygonSoup soup = cut(turned);
          ASSERT_EQ(soup.triangles.size(), outline.size() - 2);
          Vec3 sum(0);
          double area = 0;
          for (const auto& t : soup.triangles) {
            sum += areaVector(soup, t);
            area += glm::length(areaVector(soup, t));
          }
          // Triangles that overlapped or faced the other way would have more area than their sum.
          EXPECT_NEAR(area, glm::length(sum), 1e-12);
          EXPECT_GT(area, 0);
        }
      }
    }
  }
}

TEST(Polygon, ThatCrossesItselfOrHasNoAreaStillGivesAllItsTriangles) {
  EXPECT_EQ(cut({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}).triangles.size(), 2U);
  EXPECT_EQ(cut({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}}).triangles.size(), 3U);
  EXPECT_EQ(cut(std::vector<Vec3>(6, Vec3(1))).triangles.size(), 4U);
}

/// By trying every corner again for each ear. Counter-clockwise about z.
std::vector<TriangleIndices> cutSlowly(const std::vector<Vec3>& at) {
  const auto turn = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return glm::cross(at[b] - at[a], at[c] - at[a]).z;
  };
  std::vector<std::uint32_t> left(at.size());
  std::iota(left.begin(), left.end(), 0U);
  std::vector<TriangleIndices> triangles;
  bool isConvex = true;  // then a fan does
  for (std::uint32_t i = 0; i < at.size(); ++i) {
    const auto n = static_cast<std::uint32_t>(at.size());
    isConvex = isConvex && turn(i, (i + 1) % n, (i + 2) % n) >= 0;
  }
  for (std::size_t i = 0; !isConvex && left.size() > 3 && i < left.size();) {
    const std::uint32_t a = left[(i + left.size() - 1) % left.size()], b = left[i], c = left[(i + 1) % left.size()];
    const bool isFree = std::ranges::none_of(left, [&](std::uint32_t p) {
      return p != a && p != b && p != c && turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
    });
    if (turn(a, b, c) <= 0 || !isFree) {
      ++i;
      continue;
    }
    triangles.push_back({a, b, c});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
    i = 0;
  }
  for (std::size_t i = 1; i + 1 < left.size(); ++i) triangles.push_back({left[0], left[i], left[i + 1]});
  return triangles;
}

TEST(Polygon, IsCutAsByTryingAllCornersAgain) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> radius(0.1, 1);
  for (const int corners : {5, 12, 60, 200}) {
    for (const int turns : {1, 2}) {  // the second crosses itself
      std::vector<Vec3> outline;
      for (int i = 0; i < corners; ++i) {
        const double angle = 2 * std::numbers::pi * turns * i / corners, r = radius(random);
        outline.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
      }
      EXPECT_EQ(cut(outline).triangles, cutSlowly(outline)) << corners << ' ' << turns;
    }
  }
}

TEST(Polygon, OfManyCornersIsCutInReasonableTime) {
  std::vector<Vec3> zigzag;
  zigzag.reserve(10'000);
  for (int i = 0; i < 5000; ++i) zigzag.emplace_back(i, i % 2, 0);
  for (int i = 5000; i > 0; --i) zigzag.emplace_back(i, 3 + i % 2, 0);
  EXPECT_EQ(cut(zigzag).triangles.size(), zigzag.size() - 2);
}

TEST(Polygon, OfTooFewCornersOrWithABadOneIsCounted) {
  PolygonSoup soup;
  soup.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  soup.addPolygon(std::vector<std::uint32_t>{0, 1});
  soup.addPolygon(std::vector<std::uint32_t>{});
  soup.addPolygon(std::vector<std::uint32_t>{0, 1, 2, 3});
  soup.addPolygon(std::vector<std::uint32_t>{0, 1, 0xFFFFFFFF});
  EXPECT_EQ(soup.degenerate, 2U);
  EXPECT_EQ(soup.outOfRange, 3U);
  EXPECT_TRUE(soup.triangles.empty());
}

}  // namespace
}  // namespace haptics::polygon_soup_test

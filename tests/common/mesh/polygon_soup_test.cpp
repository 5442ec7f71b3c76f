#include "common/mesh/polygon_soup.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>
#include <span>

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

// Outlines on a lattice, so that the judge, which is integer arithmetic, is exact.
using Lattice = std::vector<std::array<std::int64_t, 2>>;

std::int64_t twiceArea(std::span<const std::array<std::int64_t, 2>> outline) {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const auto& [x, y] = outline[i];
    const auto& [u, v] = outline[(i + 1) % outline.size()];
    sum += x * v - u * y;
  }
  return sum;
}

/// By the parity of the edges that a ray from the point crosses. The ray passes between lattice points.
bool isInside(std::span<const std::array<std::int64_t, 2>> outline, double x, double y) {
  bool inside = false;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const auto& p = outline[i];
    const auto& q = outline[(i + 1) % outline.size()];
    const auto py = static_cast<double>(p[1]), qy = static_cast<double>(q[1]);
    if ((py > y) == (qy > y)) continue;
    const auto px = static_cast<double>(p[0]), qx = static_cast<double>(q[0]);
    if (x < px + (y - py) / (qy - py) * (qx - px)) inside = !inside;
  }
  return inside;
}

/// Cut where it lies in space by `place`, no triangle faces back, none is missing or overlaps another one.
void expectCovers(const Lattice& outline, const std::function<Vec3(double, double)>& place, std::mt19937_64& random) {
  std::vector<Vec3> corners;
  for (const auto& [x, y] : outline) corners.push_back(place(static_cast<double>(x), static_cast<double>(y)));
  const PolygonSoup soup = cut(corners);
  ASSERT_EQ(soup.triangles.size(), outline.size() - 2);
  EXPECT_EQ(soup.polygonsCrossing, 0U);
  std::vector<std::array<std::array<std::int64_t, 2>, 3>> triangles;
  std::int64_t sum = 0, widest = 1;
  for (const auto [a, b, c] : soup.triangles) {
    triangles.push_back({outline[a], outline[b], outline[c]});
    const bool isLine = outline[a] == outline[b] || outline[b] == outline[c] || outline[c] == outline[a];
    EXPECT_GE(twiceArea(triangles.back()), isLine ? 0 : 1);
    sum += twiceArea(triangles.back());
  }
  EXPECT_EQ(sum, twiceArea(outline));
  for (const auto& [x, y] : outline) widest = std::max({widest, std::abs(x), std::abs(y)});
  for (int i = 0; i < 50; ++i) {
    std::uniform_int_distribution<std::int64_t> anywhere(-widest, widest);
    const double x = static_cast<double>(anywhere(random)) + 0.377, y = static_cast<double>(anywhere(random)) + 0.411;
    const auto holding = std::ranges::count_if(triangles, [&](const auto& t) { return isInside(t, x, y); });
    EXPECT_EQ(holding, isInside(outline, x, y) ? 1 : 0);
  }
}

constexpr std::int64_t kUnit = 100'000;

/// Simple: its angles grow. Counter-clockwise.
Lattice star(std::size_t corners, double least, double most, std::mt19937_64& random) {
  std::uniform_real_distribution<double> radius(least, most);
  Lattice outline;
  for (std::size_t i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(corners);
    const double r = radius(random) * kUnit;
    outline.push_back({std::llround(r * std::cos(angle)), std::llround(r * std::sin(angle))});
  }
  return outline;
}

Lattice comb(std::int64_t teeth, std::mt19937_64& random) {
  std::uniform_int_distribution<std::int64_t> height(0, kUnit);
  Lattice outline{{0, -1}, {2 * teeth, -1}};
  for (std::int64_t x = 2 * teeth; x >= 0; --x) outline.push_back({x, x % 2 == 0 ? 1 : 2 + height(random)});
  return outline;
}

Lattice spiral(std::int64_t corners) {
  Lattice outline;
  const auto add = [&](std::int64_t i, double shift) {
    const double angle = 0.13 * static_cast<double>(i), r = 1000 * (angle + shift);
    outline.push_back({std::llround(r * std::cos(angle)), std::llround(r * std::sin(angle))});
  };
  for (std::int64_t i = 40; i < corners; ++i) add(i, 3);
  for (std::int64_t i = corners - 1; i >= 40; --i) add(i, 0);
  return outline;
}

/// A star with the hole that another one is, by a bridge from corner `at` to the hole's corner of the same angle.
Lattice keyhole(std::size_t corners, std::size_t at, std::mt19937_64& random) {
  const Lattice outer = star(corners, 1.5, 2.5, random), inner = star(corners, 0.3, 1, random);
  Lattice outline;
  for (std::size_t i = 0; i <= corners; ++i) outline.push_back(outer[(at + i) % corners]);
  for (std::size_t i = 0; i <= corners; ++i) outline.push_back(inner[(at + corners - i) % corners]);
  return outline;
}

/// Every edge gets corners that lie on it.
Lattice withCornersOnEdges(const Lattice& outline) {
  Lattice more;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const auto& p = outline[i];
    const auto& q = outline[(i + 1) % outline.size()];
    for (std::int64_t k = 0; k < 3; ++k) {
      more.push_back({3 * p[0] + k * (q[0] - p[0]), 3 * p[1] + k * (q[1] - p[1])});
    }
  }
  return more;
}

TEST(Polygon, IsCoveredByItsTrianglesOnceAndNothingElseIs) {
  std::mt19937_64 random(5);
  for (const std::size_t size : {7U, 40U, 300U, 1500U}) {
    const auto teeth = static_cast<std::int64_t>(size);
    for (const auto& outline :
         {star(size, 0.1, 1, random), star(size, 0.9, 0.92, random), comb(teeth, random), spiral(40 + teeth),
          keyhole(size, size / 3, random), withCornersOnEdges(star(size, 0.2, 1, random)),
          withCornersOnEdges(keyhole(size, size / 2, random)), withCornersOnEdges({{0, 0}, {9, 0}, {9, 9}, {0, 9}})}) {
      ASSERT_GT(twiceArea(outline), 0);
      expectCovers(
          outline, [](double x, double y) { return Vec3(x, y, 0); }, random);
      expectCovers(
          outline, [](double x, double y) { return Vec3(0.5 * y - 0.25 * x, x, y); }, random);
      // Bent by a thousandth of its size.
      expectCovers(
          outline, [](double x, double y) { return Vec3(x, y, 100 * std::sin(x / 1e4) * std::cos(y / 1e4)); }, random);
    }
  }
}

TEST(Polygon, ThatTouchesItselfOrRepeatsACornerIsCovered) {
  std::mt19937_64 random(6);
  // A square with a hole whose corner is the square's own, and one that is a bridge away but touches another corner.
  for (const auto& outline : {Lattice{{0, 0}, {8, 0}, {8, 8}, {0, 8}, {0, 0}, {2, 4}, {4, 2}},
                              Lattice{{0, 0}, {8, 0}, {8, 8}, {0, 8}, {0, 0}, {4, 6}, {8, 8}, {6, 4}, {4, 6}},
                              // A corner that is repeated, and a line there and back.
                              Lattice{{0, 0}, {8, 0}, {8, 0}, {8, 8}, {3, 4}, {3, 4}, {3, 4}, {0, 8}},
                              Lattice{{0, 0}, {8, 0}, {8, 8}, {4, 8}, {4, 3}, {4, 8}, {0, 8}}}) {
    ASSERT_GT(twiceArea(outline), 0);
    for (std::size_t first = 0; first < outline.size(); ++first) {
      Lattice turned = outline;
      std::ranges::rotate(turned, turned.begin() + static_cast<std::ptrdiff_t>(first));
      expectCovers(
          turned, [](double x, double y) { return Vec3(x, y, 0); }, random);
    }
  }
}

TEST(Polygon, ThatCrossesItselfIsCounted) {
  EXPECT_EQ(cut({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 2, 0}}).polygonsCrossing, 1U);
  std::vector<Vec3> pentagram;
  for (int i = 0; i < 5; ++i)
    pentagram.emplace_back(std::cos(0.8 * i * std::numbers::pi), std::sin(0.8 * i * std::numbers::pi), 0);
  EXPECT_EQ(cut(pentagram).triangles.size(), 3U);
}

TEST(Polygon, OfManyCornersIsCutWithoutTryingAllOfThemAgain) {
  std::mt19937_64 random(7);
  for (const auto& outline : {star(100'000, 0.3, 1, random), comb(50'000, random), spiral(50'000)}) {
    std::vector<Vec3> corners;
    for (const auto& [x, y] : outline) corners.emplace_back(x, y, 0);
    EXPECT_EQ(cut(corners).triangles.size(), corners.size() - 2);
  }
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

// Stars with squares and diamonds in rows, so that bridges lead along edges and to corners that others lead to, too.
TEST(Polygon, WithHolesIsCutAroundThem) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int round = 0; round < 200; ++round) {
    const Quat turned =
        round % 2 == 0 ? Quat(1, 0, 0, 0) : glm::normalize(Quat(number(random), number(random), number(random), 0.1));
    std::vector<Vec3> places;
    double area = 0;
    const auto put = [&](const std::vector<Vec3>& outline) {
      std::vector<std::uint32_t> corners;
      double inside = 0;
      for (std::size_t i = 0; i < outline.size(); ++i) {
        inside += glm::cross(outline[i], outline[(i + 1) % outline.size()]).z / 2;
        corners.push_back(static_cast<std::uint32_t>(places.size()));
        places.push_back(turned * outline[i]);
      }
      area += area == 0 ? inside : -inside;
      return corners;
    };
    std::vector<Vec3> star;
    for (int i = 0; i < 16; ++i) {
      const double angle = std::numbers::pi * i / 8, r = 2.5 + number(random);
      star.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
    }
    const auto outline = put(star);
    std::vector<std::vector<std::uint32_t>> holes;
    for (int i = 0; i < round % 17; ++i) {
      const double r = 0.05 + 0.04 * number(random);
      const Vec3 centre(0.4 * (i % 4) - 0.6, 0.4 * (i / 4) - 0.6, 0);
      const auto at = [&](double x, double y) { return centre + r * Vec3(x, y, 0); };
      holes.push_back(put(i % 3 == 0 ? std::vector{at(1, 0), at(0, 1), at(-1, 0), at(0, -1)}
                                     : std::vector{at(1, 1), at(-1, 1), at(-1, -1), at(1, -1)}));
      if (i % 2 == 0) std::ranges::reverse(holes.back());
    }
    const auto joined = joinedOutline(outline, holes, places);
    EXPECT_EQ(joined.size(), outline.size() + holes.size() * 6);
    PolygonSoup soup;
    soup.vertices = places;
    soup.addPolygon(joined);
    double covered = 0;
    for (const TriangleIndices& triangle : soup.triangles) {
      const double part = glm::dot(areaVector(soup, triangle), turned * Vec3(0, 0, 1));
      EXPECT_GE(part, -1e-9) << round;
      covered += part;
    }
    EXPECT_NEAR(covered, area, 1e-9) << round;
  }
}

TEST(Polygon, JoinsAHoleBetweenTheBridgesOfTwo) {
  const std::vector<Vec3> places{{0, 0, 0},   {2, 0, 0},     {3, 2, 0},
                                 {2, 4, 0},   {0, 4, 0},                      // the right corner sees all
                                 {1.2, 3, 0}, {1, 3.1, 0},   {1, 2.9, 0},     // above
                                 {1, 1, 0},   {0.8, 1.1, 0}, {0.8, 0.9, 0},   // below
                                 {0.5, 2, 0}, {0.3, 2.1, 0}, {0.3, 1.9, 0}};  // as high as it
  EXPECT_EQ(joinedOutline({0, 1, 2, 3, 4}, {{5, 6, 7}, {8, 9, 10}, {11, 12, 13}}, places),
            (std::vector<std::uint32_t>{0, 1, 2, 8, 10, 9, 8, 2, 11, 13, 12, 11, 2, 5, 7, 6, 5, 2, 3, 4}));
}

TEST(Polygon, TakesAHoleOutsideForWhatItIs) {
  const std::vector<Vec3> places{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}};
  EXPECT_EQ(joinedOutline({0, 1, 2}, {{3, 4, 5}, {3, 4}}, places).size(), 8U);
}

}  // namespace
}  // namespace haptics::polygon_soup_test

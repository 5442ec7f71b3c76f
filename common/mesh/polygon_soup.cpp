#include "common/mesh/polygon_soup.h"

#include <algorithm>
#include <cstddef>
#include <glm/vec2.hpp>

namespace haptics {
namespace {

using Point = glm::dvec2;

/// Largest number of corners of a non-convex polygon that is cut by ears, which takes time up to its cube (1,000: about
/// a second at worst). Larger ones are cut as a fan, which is right only when all corners are seen from the first.
constexpr std::size_t kMostEarCorners = 1000;

/// Twice the area of the triangle; > 0 when it turns left.
double turn(Point a, Point b, Point c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

/// The corners seen along the polygon's normal (Newell's sum), so that the outline runs counter-clockwise.
std::vector<Point> flattened(std::span<const std::uint32_t> corners, const std::vector<Vec3>& vertices) {
  Vec3 normal(0);
  const Vec3 origin = vertices[corners[0]];
  for (std::size_t i = 0; i < corners.size(); ++i) {
    normal += glm::cross(vertices[corners[i]] - origin, vertices[corners[(i + 1) % corners.size()]] - origin);
  }
  const Vec3 size = glm::abs(normal);
  const int drop = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  int u = (drop + 1) % 3, v = (drop + 2) % 3;
  if (normal[drop] < 0) std::swap(u, v);
  std::vector<Point> flat;
  flat.reserve(corners.size());
  for (const std::uint32_t corner : corners) flat.emplace_back(vertices[corner][u], vertices[corner][v]);
  return flat;
}

bool isConvex(const std::vector<Point>& flat) {
  const std::size_t n = flat.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (turn(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) < 0) return false;
  }
  return true;
}

/// An ear is a left turn whose triangle holds no other corner.
bool isEar(const std::vector<Point>& flat, const std::vector<std::size_t>& left, std::size_t i) {
  const std::size_t n = left.size();
  const std::size_t before = left[(i + n - 1) % n], here = left[i], after = left[(i + 1) % n];
  const Point a = flat[before], b = flat[here], c = flat[after];
  if (turn(a, b, c) <= 0) return false;
  return std::none_of(left.begin(), left.end(), [&](std::size_t k) {
    const Point p = flat[k];
    if (p == a || p == b || p == c) return false;
    return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
  });
}

/// Moves triangles from the outline `left` to `triangles` until it is a triangle or has no ear.
void clipEars(const std::vector<Point>& flat, std::span<const std::uint32_t> corners, std::vector<std::size_t>& left,
              std::vector<TriangleIndices>& triangles) {
  for (std::size_t i = 0; left.size() > 3 && i < left.size();) {
    if (!isEar(flat, left, i)) {
      ++i;
      continue;
    }
    const std::size_t n = left.size();
    triangles.push_back({corners[left[(i + n - 1) % n]], corners[left[i]], corners[left[(i + 1) % n]]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
    i = 0;
  }
}

}  // namespace

// Ear clipping (Meisters 1975). Where no ear is left (the outline crosses itself) the rest is cut as a fan.
void PolygonSoup::addPolygon(std::span<const std::uint32_t> corners) {
  const std::size_t n = corners.size();
  if (n < 3) {
    ++degenerate;
    return;
  }
  if (std::any_of(corners.begin(), corners.end(), [this](std::uint32_t v) { return v >= vertices.size(); })) {
    outOfRange += n - 2;
    return;
  }
  if (n > 3) ++polygonsTriangulated;

  std::vector<std::size_t> left(n);
  for (std::size_t i = 0; i < n; ++i) left[i] = i;
  if (n > 3 && n <= kMostEarCorners) {
    const std::vector<Point> flat = flattened(corners, vertices);
    if (!isConvex(flat)) clipEars(flat, corners, left, triangles);
  }
  for (std::size_t i = 1; i + 1 < left.size(); ++i) {
    triangles.push_back({corners[left[0]], corners[left[i]], corners[left[i + 1]]});
  }
}

}  // namespace haptics

#include "common/mesh/polygon_soup.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <glm/vec2.hpp>
#include <optional>
#include <utility>

namespace haptics {
namespace {

using Point = glm::dvec2;

/// Largest number of corners of a non-convex polygon that is cut by ears, which takes time up to its square. Larger ones are cut as a fan, which is right only when all corners are seen from the first.
constexpr std::size_t kMaxEarCorners = 1000;

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

/// A polygon's corners of which ears are cut off: left turns whose triangle holds no other corner. A corner that was found
/// in a triangle is remembered, so that a polygon of n corners takes O(n^2).
class Outline {
 public:
  explicit Outline(const std::vector<Point>& flat) : flat_(flat), corners_(flat.size()) {
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      corners_[i].before = (i + corners_.size() - 1) % corners_.size();
      corners_[i].after = (i + 1) % corners_.size();
    }
  }

  /// The first ear, as the corners before, at and after it, is cut off. None: there is none.
  std::optional<std::array<std::size_t, 3>> cutEar() {
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if (corners_[i].isCut || !isEar(i)) continue;
      const auto [before, after, inside, isCut] = corners_[i];
      corners_[i].isCut = true;
      corners_[before].after = after;
      corners_[after].before = before;
      corners_[before].inside = corners_[after].inside = 0;
      return std::array{before, i, after};
    }
    return std::nullopt;
  }

  [[nodiscard]] std::vector<std::size_t> left() const {
    std::vector<std::size_t> left;
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if (!corners_[i].isCut) left.push_back(i);
    }
    return left;
  }

 private:
  struct Corner {
    std::size_t before, after;
    std::size_t inside = 0;  ///< None of those before this one is in the triangle.
    bool isCut = false;
  };

  [[nodiscard]] bool isEar(std::size_t i) {
    Corner& corner = corners_[i];
    const Point a = flat_[corner.before], b = flat_[i], c = flat_[corner.after];
    if (turn(a, b, c) <= 0) return false;
    const auto isIn = [&](std::size_t k) {
      const Point p = flat_[k];
      return !corners_[k].isCut && turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0 && p != a && p != b &&
             p != c;
    };
    while (corner.inside < corners_.size() && !isIn(corner.inside)) ++corner.inside;
    return corner.inside == corners_.size();
  }

  const std::vector<Point>& flat_;
  std::vector<Corner> corners_;
};

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
  if (n > 3 && n <= kMaxEarCorners) {
    const std::vector<Point> flat = flattened(corners, vertices);
    if (!isConvex(flat)) {
      Outline outline(flat);
      for (std::size_t cut = 0; cut + 3 < n; ++cut) {
        const auto ear = outline.cutEar();
        if (!ear) break;
        triangles.push_back({corners[(*ear)[0]], corners[(*ear)[1]], corners[(*ear)[2]]});
      }
      left = outline.left();
    }
  }
  for (std::size_t i = 1; i + 1 < left.size(); ++i) {
    triangles.push_back({corners[left[0]], corners[left[i]], corners[left[i + 1]]});
  }
}

}  // namespace haptics

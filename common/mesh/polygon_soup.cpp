#include "common/mesh/polygon_soup.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <queue>
#include <utility>

namespace haptics {
namespace {

using Point = glm::dvec2;

/// Twice the area of the triangle; > 0 when it turns left.
double turn(Point a, Point b, Point c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

/// Two of the axes, along which a polygon is seen.
struct Sides {
  int u, v;
  [[nodiscard]] Point of(const Vec3& place) const { return {place[u], place[v]}; }
};

/// Along the polygon's normal (Newell's sum), so that the outline runs counter-clockwise.
Sides sidesOf(std::span<const std::uint32_t> corners, const std::vector<Vec3>& vertices) {
  Vec3 normal(0);
  const Vec3 origin = vertices[corners[0]];
  for (std::size_t i = 0; i < corners.size(); ++i) {
    normal += glm::cross(vertices[corners[i]] - origin, vertices[corners[(i + 1) % corners.size()]] - origin);
  }
  const Vec3 size = glm::abs(normal);
  const int drop = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  int u = (drop + 1) % 3, v = (drop + 2) % 3;
  if (normal[drop] < 0) std::swap(u, v);
  return {u, v};
}

std::vector<Point> flattened(std::span<const std::uint32_t> corners, const std::vector<Vec3>& vertices,
                             const Sides& sides) {
  std::vector<Point> flat;
  flat.reserve(corners.size());
  for (const std::uint32_t corner : corners) flat.push_back(sides.of(vertices[corner]));
  return flat;
}

double areaOf(const std::vector<Point>& outline) {
  double area = 0;
  for (std::size_t i = 2; i < outline.size(); ++i) area += turn(outline[0], outline[i - 1], outline[i]);
  return area;
}

/// Whether the way from the corner to the point leaves into the outline.
bool leadsIn(const std::vector<Point>& outline, std::size_t corner, Point point) {
  const std::size_t n = outline.size();
  const Point before = outline[(corner + n - 1) % n], at = outline[corner], after = outline[(corner + 1) % n];
  const bool left = turn(before, at, point) >= 0, right = turn(at, after, point) >= 0;
  return turn(before, at, after) >= 0 ? left && right : left || right;
}

/// A corner that sees the point, which is in the outline, to its right (Eberly, Triangulation by Ear Clipping, 2002): of several
/// in one place any.
std::size_t placeSeenFrom(const std::vector<Point>& outline, Point from) {
  const std::size_t n = outline.size();
  std::size_t seen = n;
  double wall = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i) {
    const Point a = outline[i], b = outline[(i + 1) % n];
    if (a.y > from.y || b.y < from.y || a.y == b.y) continue;  // of walls to the right, which run upwards
    const double x = a.x + (b.x - a.x) * ((from.y - a.y) / (b.y - a.y));
    if (x < from.x || x >= wall) continue;
    wall = x;
    seen = b.x > a.x ? (i + 1) % n : i;
    if (from.y == a.y) seen = i;
    if (from.y == b.y) seen = (i + 1) % n;
  }
  const auto distance2 = [&](std::size_t i) { return glm::dot(outline[i] - from, outline[i] - from); };
  if (seen == n) {  // the hole is not in it
    for (std::size_t i = seen = 0; i < n; ++i) seen = distance2(i) < distance2(seen) ? i : seen;
    return seen;
  }
  const Point end = outline[seen], hit(wall, from.y);
  if (end == hit) return seen;
  const Point low = end.y < from.y ? end : hit, high = end.y < from.y ? hit : end;
  double least = std::abs(end.y - from.y) / (end.x - from.x);
  for (std::size_t i = 0; i < n; ++i) {
    const Point p = outline[i];
    if (p.x <= from.x || turn(from, low, p) < 0 || turn(low, high, p) < 0 || turn(high, from, p) < 0) continue;
    const double slope = std::abs(p.y - from.y) / (p.x - from.x);
    if (slope > least || (slope == least && distance2(i) >= distance2(seen)) || !leadsIn(outline, i, from)) continue;
    least = slope;
    seen = i;
  }
  return seen;
}

std::size_t cornerSeenFrom(const std::vector<Point>& outline, Point from) {
  const std::size_t seen = placeSeenFrom(outline, from);
  for (std::size_t i = 0; i < outline.size(); ++i) {
    if (outline[i] == outline[seen] && leadsIn(outline, i, from)) return i;
  }
  return seen;
}

/// Whether the triangles from the first corner are the polygon: it is convex, goes round once, and none is without area.
bool isFan(const std::vector<Point>& flat) {
  const std::size_t n = flat.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (turn(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) < 0) return false;
  }
  for (std::size_t i = 2; i < n; ++i) {
    if (turn(flat[0], flat[1], flat[i]) <= 0 || (i > 2 && turn(flat[0], flat[i - 1], flat[i]) <= 0)) return false;
  }
  return true;
}

/// Of points those that are `in`, which are taken out one by one, in a tree of boxes.
class PointTree {
 public:
  PointTree(const std::vector<Point>& points, std::vector<std::size_t> in)
      : points_(points), order_(std::move(in)), place_(points.size(), kNone) {
    if (!order_.empty()) build(0, 0, order_.size());
    ordered_.reserve(order_.size());
    for (std::size_t i = 0; i < order_.size(); ++i) {
      place_[order_[i]] = i;
      ordered_.push_back(points_[order_[i]]);
    }
  }

  void remove(std::size_t point) {
    const std::size_t place = std::exchange(place_[point], kNone);
    if (place == kNone) return;
    std::size_t node = 0, first = 0, last = order_.size();
    for (;;) {
      --nodes_[node].count;
      if (last - first <= kLeaf) break;
      const std::size_t middle = (first + last) / 2;
      node = 2 * node + (place < middle ? 1 : 2);
      (place < middle ? last : first) = middle;
    }
    ordered_[place] = Point(std::numeric_limits<double>::quiet_NaN());
  }

  /// A point in the triangle, its edges included, of which `counts`; kNone: there is none.
  template <typename Counts>
  [[nodiscard]] std::size_t anyIn(Point a, Point b, Point c, const Counts& counts) const {
    const std::array<Edge, 3> edges{Edge(a, b), Edge(b, c), Edge(c, a)};
    const Point low = glm::min(glm::min(a, b), c), high = glm::max(glm::max(a, b), c);
    struct Part {
      std::size_t node, first, last;
    };
    std::array<Part, 64> stack;
    std::size_t top = 0;
    if (!order_.empty()) stack[top++] = {0, 0, order_.size()};
    while (top > 0) {
      const auto [node, first, last] = stack[--top];
      const Node& box = nodes_[node];
      if (box.count == 0 || high.x < box.ends[0].x || low.x > box.ends[1].x || high.y < box.ends[0].y ||
          low.y > box.ends[1].y || !edges[0].mayHaveToItsLeft(box) || !edges[1].mayHaveToItsLeft(box) ||
          !edges[2].mayHaveToItsLeft(box))
        continue;
      if (last - first > kLeaf) {
        const std::size_t middle = (first + last) / 2;
        stack[top++] = {2 * node + 2, middle, last};
        stack[top++] = {2 * node + 1, first, middle};
        continue;
      }
      for (std::size_t i = first; i < last; ++i) {
        const Point p = ordered_[i];
        if (edges[0].hasToItsLeft(p) && edges[1].hasToItsLeft(p) && edges[2].hasToItsLeft(p) && counts(order_[i]))
          return order_[i];
      }
    }
    return kNone;
  }

  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

 private:
  static constexpr std::size_t kLeaf = 16;
  struct Node {
    std::array<Point, 2> ends;  // low, high
    std::size_t count = 0;
  };

  void build(std::size_t node, std::size_t first, std::size_t last) {
    if (nodes_.size() <= node) nodes_.resize(node + 1);
    Point low = points_[order_[first]], high = low;
    for (std::size_t i = first; i < last; ++i) {
      low = glm::min(low, points_[order_[i]]);
      high = glm::max(high, points_[order_[i]]);
    }
    nodes_[node] = {{low, high}, last - first};
    if (last - first <= kLeaf) return;
    const int axis = high.x - low.x >= high.y - low.y ? 0 : 1;
    const std::size_t middle = (first + last) / 2;
    const auto at = [this](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(first), at(middle), at(last),
                     [&](std::size_t p, std::size_t q) { return points_[p][axis] < points_[q][axis]; });
    build(2 * node + 1, first, middle);
    build(2 * node + 2, middle, last);
  }

  /// An edge of a triangle, with the corner of every box that is furthest to its left: as rounded, too, turn() is largest there.
  struct Edge {
    Point from, to;
    int u, v;  // of Node::ends
    Edge(Point a, Point b) : from(a), to(b), u(b.y > a.y ? 0 : 1), v(b.x > a.x ? 1 : 0) {}
    [[nodiscard]] bool mayHaveToItsLeft(const Node& box) const {
      return turn(from, to, {box.ends[u].x, box.ends[v].y}) >= 0;
    }
    [[nodiscard]] bool hasToItsLeft(Point p) const { return turn(from, to, p) >= 0; }
  };

  const std::vector<Point>& points_;
  std::vector<std::size_t> order_;
  std::vector<Point> ordered_;      // not a number: taken out
  std::vector<std::size_t> place_;  // in order_
  std::vector<Node> nodes_;         // the children of node i are 2 i + 1 and 2 i + 2
};

/// A polygon's corners of which ears are cut off: left turns whose triangle holds no other corner. A corner that is no ear
/// is looked at again when a neighbour, or the corner that was found in its triangle, is cut off. The
/// shortest cut comes first, so that triangles, and with them the searches, stay small.
class Outline {
 public:
  explicit Outline(const std::vector<Point>& flat)
      : flat_(flat), corners_(flat.size()), tree_(flat, notLeftTurns(flat)), waiting_(flat.size()) {
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      corners_[i].before = (i + corners_.size() - 1) % corners_.size();
      corners_[i].after = (i + 1) % corners_.size();
      lookAgainAt(i);
    }
  }

  /// The ear with the shortest cut, as the corners before, at and after it, is cut off. None: there is none.
  std::optional<std::array<std::size_t, 3>> cutEar() {
    while (!queue_.empty()) {
      const auto shortest = queue_.begin();
      const auto [i, looks] = shortest->second.front();
      shortest->second.pop();
      if (shortest->second.empty()) queue_.erase(shortest);
      if (looks != corners_[i].looks || !isEar(i)) continue;
      const std::size_t before = corners_[i].before, after = corners_[i].after;
      corners_[i].isCut = true;
      corners_[before].after = after;
      corners_[after].before = before;
      tree_.remove(i);
      lookAgainAt(before);
      lookAgainAt(after);
      for (const std::size_t corner : waiting_[i]) {
        if (!corners_[corner].isCut) lookAgainAt(corner);
      }
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
  /// Outdated: the corner has more looks by now.
  struct Look {
    std::size_t corner, looks;
  };
  struct Corner {
    std::size_t before, after;
    std::size_t looks = 0;
    bool isCut = false;
  };

  /// Of lengths within 2^(1/8) of each other; shorter ones have a lower class.
  static std::uint64_t classOf(double length2) {
    constexpr int kMantissaBits = 52, kBitsOfClass = 2;
    return std::bit_cast<std::uint64_t>(length2) >> (kMantissaBits - kBitsOfClass);
  }

  static std::vector<std::size_t> notLeftTurns(const std::vector<Point>& flat) {
    std::vector<std::size_t> corners;
    const std::size_t n = flat.size();
    for (std::size_t i = 0; i < n; ++i) {
      if (!(turn(flat[(i + n - 1) % n], flat[i], flat[(i + 1) % n]) > 0)) corners.push_back(i);
    }
    return corners;
  }

  /// Not of a corner that turns right: that is no ear before a neighbour is cut off.
  void lookAgainAt(std::size_t corner) {
    Corner& its = corners_[corner];
    const Point a = flat_[its.before], b = flat_[corner], c = flat_[its.after];
    ++its.looks;
    const bool turnsLeft = turn(a, b, c) > 0;
    if (turnsLeft) tree_.remove(corner);
    if (turnsLeft || a == b || b == c || c == a) queue_[classOf(glm::dot(c - a, c - a))].push({corner, its.looks});
  }

  [[nodiscard]] bool isEar(std::size_t i) {
    const Point a = flat_[corners_[i].before], b = flat_[i], c = flat_[corners_[i].after];
    if (a == b || b == c || c == a) return true;  // nothing, or there and back
    // Other corners at the same places are outside, but for one at the ear's tip whose edges leave into the ear.
    const auto intoEar = [&](Point p) { return turn(a, b, p) > 0 && turn(b, c, p) > 0; };
    const auto isIn = [&](std::size_t k) {
      const Point p = flat_[k];
      if (p == b) return k != i && (intoEar(flat_[corners_[k].before]) || intoEar(flat_[corners_[k].after]));
      return p != a && p != c;
    };
    const std::size_t inside = tree_.anyIn(a, b, c, isIn);
    if (inside == PointTree::kNone) return true;
    waiting_[inside].push_back(i);
    return false;
  }

  const std::vector<Point>& flat_;
  std::vector<Corner> corners_;
  PointTree tree_;  // of the corners that do not turn left: an ear that holds any corner holds one of them
  std::vector<std::vector<std::size_t>> waiting_;    // for the corner that was found in their triangle
  std::map<std::uint64_t, std::queue<Look>> queue_;  // of each class of lengths
};

/// Whether the fan of the corners that are left faces back, by more than rounding.
bool foldsOver(const std::vector<Point>& flat, const std::vector<std::size_t>& left) {
  constexpr double kRounding = 1e-12;
  double size = 0;
  for (const Point p : flat) size = std::max({size, std::abs(p.x - flat[0].x), std::abs(p.y - flat[0].y)});
  for (std::size_t i = 1; i + 1 < left.size(); ++i) {
    if (turn(flat[left[0]], flat[left[i]], flat[left[i + 1]]) < -kRounding * size * size) return true;
  }
  return false;
}

}  // namespace

std::vector<std::uint32_t> joinedOutline(std::vector<std::uint32_t> outline,
                                         std::vector<std::vector<std::uint32_t>> holes,
                                         const std::vector<Vec3>& places) {
  if (outline.size() < 3) return outline;
  const Sides sides = sidesOf(outline, places);
  const auto x = [&](std::uint32_t corner) { return sides.of(places[corner]).x; };
  std::erase_if(holes, [](const auto& hole) { return hole.size() < 3; });
  for (auto& hole : holes) {
    if (areaOf(flattened(hole, places, sides)) > 0) std::reverse(hole.begin(), hole.end());
    std::rotate(hole.begin(), std::ranges::max_element(hole, {}, x), hole.end());
  }
  std::ranges::stable_sort(holes, std::greater{}, [&](const auto& hole) { return x(hole.front()); });
  std::vector<Point> flat = flattened(outline, places, sides);
  for (const auto& hole : holes) {
    const std::size_t bridge = cornerSeenFrom(flat, sides.of(places[hole.front()]));
    std::vector<std::uint32_t> detour(hole);
    detour.insert(detour.end(), {hole.front(), outline[bridge]});
    outline.insert(outline.begin() + static_cast<std::ptrdiff_t>(bridge) + 1, detour.begin(), detour.end());
    const std::vector<Point> seen = flattened(detour, places, sides);
    flat.insert(flat.begin() + static_cast<std::ptrdiff_t>(bridge) + 1, seen.begin(), seen.end());
  }
  return outline;
}

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
  std::iota(left.begin(), left.end(), std::size_t{0});
  if (n > 3) {
    const std::vector<Point> flat = flattened(corners, vertices, sidesOf(corners, vertices));
    if (!isFan(flat)) {
      Outline outline(flat);
      for (std::size_t cut = 0; cut + 3 < n; ++cut) {
        const auto ear = outline.cutEar();
        if (!ear) break;
        triangles.push_back({corners[(*ear)[0]], corners[(*ear)[1]], corners[(*ear)[2]]});
      }
      left = outline.left();
      if (foldsOver(flat, left)) ++polygonsCrossing;
    }
  }
  for (std::size_t i = 1; i + 1 < left.size(); ++i) {
    triangles.push_back({corners[left[0]], corners[left[i]], corners[left[i + 1]]});
  }
}

}  // namespace haptics

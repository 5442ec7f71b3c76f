#pragma once

#include <smmintrin.h>

#include <array>
#include <bit>
#include <cstdint>
#include <limits>

#include "common/maths/vec.h"

namespace haptics {

inline constexpr std::uint32_t kNoTriangle = std::numeric_limits<std::uint32_t>::max();

[[nodiscard]] inline Vec3 unitOrZero(Vec3 v) noexcept {
  const double length = glm::length(v);
  return length > 0 ? v / length : Vec3(0);
}

/// The corner after corner k of a triangle.
[[nodiscard]] constexpr int nextCorner(int k) noexcept { return k == 2 ? 0 : k + 1; }
[[nodiscard]] constexpr int previousCorner(int k) noexcept { return k == 0 ? 2 : k - 1; }

/// All that one step of the search needs of a polygon, in one cache line. Corners keep the mesh's canonical order, so
/// corner k and edge k (corner k to corner k + 1) are canonical numbers too. Object frame, metres.
struct alignas(64) TriangleRecord {
  static constexpr std::uint32_t kCrossed = 1;     ///< Another part of the same mesh passes through this triangle.
  static constexpr std::uint32_t kZeroArea = 2;    ///< Its corners lie exactly on one line.
  static constexpr std::uint32_t kOpenCorner = 4;  ///< Shifted left by k: the polygons at corner k are no closed fan.

  /// Row d holds coordinate d of the three corners and, in its last place, the bits of the neighbour across edge d.
  std::array<std::array<float, 4>, 3> rows;
  std::array<std::uint32_t, 3> vertex;  ///< Canonical vertex indices.
  std::uint32_t flags;

  [[nodiscard]] Vec3 corner(int k) const noexcept {
    const auto i = static_cast<std::size_t>(k);
    return {rows[0][i], rows[1][i], rows[2][i]};
  }
  /// Counter-clockwise seen from outside; its length is twice the area (m^2).
  [[nodiscard]] Vec3 areaNormal() const noexcept {
    const Vec3 a = corner(0);
    return glm::cross(corner(1) - a, corner(2) - a);
  }
  /// The triangle across edge k, or kNoTriangle when the edge is a boundary.
  [[nodiscard]] std::uint32_t neighbour(int k) const noexcept {
    return std::bit_cast<std::uint32_t>(rows[static_cast<std::size_t>(k)][3]);
  }
  void setNeighbour(int k, std::uint32_t triangle) noexcept {
    rows[static_cast<std::size_t>(k)][3] = std::bit_cast<float>(triangle);
  }
  /// The corner at which the triangle has this vertex, or -1.
  [[nodiscard]] int cornerOf(std::uint32_t v) const noexcept {
    return vertex[0] == v ? 0 : vertex[1] == v ? 1 : vertex[2] == v ? 2 : -1;
  }
  [[nodiscard]] std::uint32_t vertexAt(int k) const noexcept { return vertex[static_cast<std::size_t>(k)]; }
  [[nodiscard]] bool crossed() const noexcept { return (flags & kCrossed) != 0; }
  [[nodiscard]] bool zeroArea() const noexcept { return (flags & kZeroArea) != 0; }
  [[nodiscard]] bool openAt(int k) const noexcept { return (flags & (kOpenCorner << k)) != 0; }
};
static_assert(sizeof(TriangleRecord) == 64, "one cache line");

/// The geometric primitives of the paper's database (3.1).
enum class Feature : std::uint8_t { kPolygon, kLine, kVertex };

/// The point of a triangle that is closest to some h, and the primitive that holds it.
struct Foot {
  std::uint32_t triangle = kNoTriangle;
  Feature feature = Feature::kPolygon;
  std::uint8_t index = 0;                                            ///< Of the line or vertex in the triangle.
  Vec3 point{0};                                                     ///< Object frame, metres.
  double squaredDistance = std::numeric_limits<double>::infinity();  ///< |h - point|^2, m^2.
};

namespace detail {

/// Closest point to h of edge k, in place of `best` when it is strictly closer. Ends go to the vertices.
inline void closestOnEdge(const TriangleRecord& record, int k, Vec3 h, Foot& best) noexcept {
  const Vec3 a = record.corner(k);
  const Vec3 edge = record.corner(nextCorner(k)) - a;
  const double along = glm::dot(h - a, edge);
  const double end = squaredLength(edge);
  Foot foot{best.triangle, Feature::kLine, static_cast<std::uint8_t>(k)};
  if (along <= 0 || along >= end) {
    const int corner = along <= 0 ? k : nextCorner(k);
    foot.feature = Feature::kVertex;
    foot.index = static_cast<std::uint8_t>(corner);
    foot.point = record.corner(corner);
  } else {
    foot.point = a + edge * (along / end);
  }
  foot.squaredDistance = squaredLength(h - foot.point);
  if (foot.squaredDistance < best.squaredDistance) best = foot;
}

}  // namespace detail

/// h (object frame, metres) against a triangle's plane and against the planes through its edges along the normal.
class Prism {
 public:
  Prism(const TriangleRecord& record, Vec3 h) noexcept {
    const Pairs a(record, {0, 1});  // in the upper half: of corner 1
    const Pairs b(record, {1, 2});
    const Pairs edges = b - a;
    const Pairs fromCorners = Pairs(h) - a;
    const Vec3 c = b.upper();
    normal_ = glm::cross(edges.lower(), c - a.lower());
    height_ = glm::dot(normal_, fromCorners.lower());
    squaredNormal_ = squaredLength(normal_);
    const __m128d inner = dot(cross(Pairs(normal_), edges), fromCorners);
    const double inner2 = glm::dot(glm::cross(normal_, a.lower() - c), h - c);
    inside_ = _mm_movemask_pd(_mm_cmpgt_pd(inner, _mm_setzero_pd())) | (inner2 > 0 ? 4 : 0);
  }

  /// As areaNormal(), bit for bit.
  [[nodiscard]] Vec3 normal() const noexcept { return normal_; }
  [[nodiscard]] double squaredNormal() const noexcept { return squaredNormal_; }
  /// Of h above the plane, times the length of the normal; m^3.
  [[nodiscard]] double height() const noexcept { return height_; }
  /// h is on the plane through edge k or on its outer side.
  [[nodiscard]] bool beyond(int k) const noexcept { return (inside_ >> k & 1) == 0; }
  /// h is strictly within all three.
  [[nodiscard]] bool holds() const noexcept { return inside_ == 7; }
  /// Of h, onto the plane.
  [[nodiscard]] Vec3 foot(Vec3 h) const noexcept { return h - normal_ * (height_ / squaredNormal_); }

 private:
  /// Two vectors at work at once, each with the operations of glm in their order.
  struct Pairs {
    __m128d x, y, z;

    Pairs(__m128d x_, __m128d y_, __m128d z_) noexcept : x(x_), y(y_), z(z_) {}
    explicit Pairs(Vec3 both) noexcept : x(_mm_set1_pd(both.x)), y(_mm_set1_pd(both.y)), z(_mm_set1_pd(both.z)) {}
    Pairs(const TriangleRecord& r, std::array<std::size_t, 2> corners) noexcept
        : x(pair(r.rows[0], corners)), y(pair(r.rows[1], corners)), z(pair(r.rows[2], corners)) {}

    [[nodiscard]] static __m128d pair(const std::array<float, 4>& row, std::array<std::size_t, 2> at) noexcept {
      return _mm_set_pd(row[at[1]], row[at[0]]);
    }
    [[nodiscard]] Vec3 lower() const noexcept { return {_mm_cvtsd_f64(x), _mm_cvtsd_f64(y), _mm_cvtsd_f64(z)}; }
    [[nodiscard]] Vec3 upper() const noexcept {
      return Pairs(_mm_unpackhi_pd(x, x), _mm_unpackhi_pd(y, y), _mm_unpackhi_pd(z, z)).lower();
    }
    friend Pairs operator-(const Pairs& a, const Pairs& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  };
  static Pairs cross(const Pairs& a, const Pairs& b) noexcept {
    return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
  }
  static __m128d dot(const Pairs& a, const Pairs& b) noexcept { return a.x * b.x + a.y * b.y + a.z * b.z; }

  Vec3 normal_;
  double height_;
  double squaredNormal_;
  int inside_;  // bit k: strictly on the inner side of edge k
};

/// Closest point of the triangle to h (object frame, metres). Ties go to the primitive of lower dimension.
/// `prism` is the one of record and h.
///
/// Tests h against the prism over the triangle rather than by products of dot products (Ericson, Real-Time Collision
/// Detection, 5.1.5): the error is then of the order of the distance over the triangle's width, not of its square,
/// which a sliver needs. The closest point lies on an edge that h is beyond, so only those are looked at.
[[nodiscard]] inline Foot closestOn(const TriangleRecord& record, std::uint32_t triangle, Vec3 h,
                                    const Prism& prism) noexcept {
  Foot foot;
  foot.triangle = triangle;
  if (prism.holds()) {
    foot.point = prism.foot(h);
    foot.squaredDistance = squaredLength(h - foot.point);
    return foot;
  }
  for (int k = 0; k < 3; ++k) {
    if (prism.beyond(k)) detail::closestOnEdge(record, k, h, foot);
  }
  return foot;
}
[[nodiscard]] inline Foot closestOn(const TriangleRecord& record, std::uint32_t triangle, Vec3 h) noexcept {
  return closestOn(record, triangle, h, Prism(record, h));
}

}  // namespace haptics

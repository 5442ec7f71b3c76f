#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <limits>

#include "common/maths/vec.h"

namespace haptics {

inline constexpr std::uint32_t kNoTriangle = std::numeric_limits<std::uint32_t>::max();

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

/// Closest point of the triangle to h (object frame, metres). Ties go to the primitive of lower dimension.
///
/// Tests h against the planes through the edges along the normal rather than by products of dot products (Ericson,
/// Real-Time Collision Detection, 5.1.5): the error is then of the order of the distance over the triangle's width, not
/// of its square, which a sliver needs. The closest point lies on an edge that h is beyond, so only those are looked
/// at.
[[nodiscard]] inline Foot closestOn(const TriangleRecord& record, std::uint32_t triangle, Vec3 h) noexcept {
  Foot foot;
  foot.triangle = triangle;
  const std::array<Vec3, 3> corner{record.corner(0), record.corner(1), record.corner(2)};
  const std::array<Vec3, 3> edge{corner[1] - corner[0], corner[2] - corner[1], corner[0] - corner[2]};
  const Vec3 normal = glm::cross(edge[0], edge[1]);
  const std::array<Vec3, 3> from{h - corner[0], h - corner[1], h - corner[2]};
  const bool beyond0 = !(glm::dot(glm::cross(normal, edge[0]), from[0]) > 0);
  const bool beyond1 = !(glm::dot(glm::cross(normal, edge[1]), from[1]) > 0);
  const bool beyond2 = !(glm::dot(glm::cross(normal, edge[2]), from[2]) > 0);
  if (!(beyond0 | beyond1 | beyond2)) {
    foot.point = h - normal * (glm::dot(normal, from[0]) / squaredLength(normal));
    foot.squaredDistance = squaredLength(h - foot.point);
    return foot;
  }
  if (beyond0) detail::closestOnEdge(record, 0, h, foot);
  if (beyond1) detail::closestOnEdge(record, 1, h, foot);
  if (beyond2) detail::closestOnEdge(record, 2, h, foot);
  return foot;
}

}  // namespace haptics

#pragma once

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
  /// Another part of the same mesh passes through this triangle, or the triangles around one of its vertices do through
  /// each other.
  static constexpr std::uint32_t kSelfIntersecting = 1;
  static constexpr std::uint32_t kZeroArea = 2;    ///< Its corners lie exactly on one line.
  static constexpr std::uint32_t kOpenCorner = 4;  ///< Shifted left by k: the polygons at corner k are no closed fan.
  static constexpr int kFlagBits = 5;
  static constexpr std::uint32_t kMaxRecords = 1U << (32 - kFlagBits);  ///< Whose numbers fit in above the flags.

  /// Row d holds coordinate d of the three corners and, in its last place, the bits of the neighbour across edge d.
  std::array<std::array<float, 4>, 3> rows;
  std::array<std::uint32_t, 3> vertex;  ///< Canonical vertex indices.
  std::uint32_t flags;                  ///< In kFlagBits bits; above them the canonical number.

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
  [[nodiscard]] std::uint32_t canonical() const noexcept { return flags >> kFlagBits; }
  [[nodiscard]] bool selfIntersecting() const noexcept { return (flags & kSelfIntersecting) != 0; }
  [[nodiscard]] bool zeroArea() const noexcept { return (flags & kZeroArea) != 0; }
  [[nodiscard]] bool openAt(int k) const noexcept { return (flags & (kOpenCorner << k)) != 0; }
};
static_assert(sizeof(TriangleRecord) == 64, "one cache line");

}  // namespace haptics

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/maths/vec.h"

namespace haptics {

using Corners = std::array<Vec3, 3>;

/// Triangles in the cells of a grid, of which each may be in many. Boxes about whole triangles that are long in no
/// direction of an axis hold mostly nothing: where there are many, every query meets a part of them all. A cell holds what
/// passes through it.
struct TriangleCells {
  struct Cell {
    Vec3f low, high;
    std::uint32_t begin = 0, end = 0;  ///< Of `listed`.
  };
  std::vector<Cell> cells;            ///< None is empty.
  std::vector<std::uint32_t> listed;  ///< Numbers of triangles.
};

/// Which of the triangles are long: longer than kLongShare of the longest side of the box about all of them but a few giants.
/// Not these, and not those
/// with a vertex of more than kMaxAtVertex, near which no cell could tell them apart. None where boxes do for them,
/// because they are few, or do not overlap: at a point, no more than kMaxOverlap in the mean.
[[nodiscard]] std::vector<std::uint32_t> longTriangles(std::span<const Vec3f> vertices,
                                                       std::span<const std::array<std::uint32_t, 3>> triangles);
/// Of the longest side.
inline constexpr double kLongShare = 1.0 / 16;
/// Triangles below which boxes do for them, however they overlap.
inline constexpr std::size_t kFewLong = 64;
inline constexpr int kMaxAtVertex = 16;
inline constexpr double kMaxOverlap = 3;

/// Puts triangles into cells, as fine as keeps them below kMaxListed each, and below kMaxListedOfAll. Finer makes
/// quicker queries, and takes memory: 4 bytes each time that a triangle is listed.
[[nodiscard]] TriangleCells cellsOf(std::span<const std::uint32_t> triangles,
                                    const std::function<Corners(std::uint32_t)>& corners);
inline constexpr double kMaxListed = 200;
inline constexpr double kMaxListedOfAll = 12e6;

}  // namespace haptics

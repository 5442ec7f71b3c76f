#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "common/mesh/work.h"

namespace haptics {

/// Corners of a hole's rim, one after the other as the missing triangles ran along it.
struct Rim {
  std::vector<std::uint32_t> corners;
  std::vector<Vec3> beside;  ///< Normal (not unit) of the triangle across the line from corner i to corner i + 1.
};

/// Triangles that close a hole without further vertices, built up from the rim so that the sharpest fold, towards what is
/// around as well, stays blunt, and the area small (Liepa, Filling Holes in Meshes, 2003, section 3). None when the rim has
/// more than kMaxCorners, there is no way without a triangle that has no area or a line for which `isTaken(a, b)`, or
/// the work does not suffice. Takes O(n^3).
inline constexpr std::size_t kMaxCorners = 128;
[[nodiscard]] std::optional<std::vector<TriangleIndices>> fillHole(
    const std::vector<Vec3f>& vertices, const Rim& rim,
    const std::function<bool(std::uint32_t, std::uint32_t)>& isTaken, Work& work);

}  // namespace haptics

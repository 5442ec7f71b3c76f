#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/tri_mesh.h"

namespace haptics {

/// Triangles of a surface that lie together and face about the same way: what is drawn, left out or drawn anew as one.
struct Patch {
  std::vector<std::uint32_t> points;       ///< Of the surface, ascending.
  std::vector<TriangleIndices> triangles;  ///< Naming `points`.
  Vec3 axis{0, 0, 1};                      ///< Unit.
  double spread_rad = 0;                   ///< Between axis and the geometric normals, at most.
  Vec3 centre{0};                          ///< Centre of a ball around the points.
  double radius_m = 0;                     ///< Radius of that ball.
};

/// Cuts a surface into patches of at most `most` triangles (> 0); a surface that has no more is one.
[[nodiscard]] std::vector<Patch> cutIntoPatches(std::span<const Vec3f> points,
                                                std::span<const TriangleIndices> triangles, std::size_t most);

/// Whether nothing of the patch is seen from the eye, in front of it or at a slant, when it is part of a closed surface.
[[nodiscard]] bool facesAway(const Patch& patch, Vec3 eye);

}  // namespace haptics

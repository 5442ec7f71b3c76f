#pragma once

#include <limits>

#include "haptic_server/contact/neighborhood_watch.h"

namespace haptics {

/// Triangles looked at before a search is no longer taken for a common one.
inline constexpr int kMostCrossed = 16;

/// A neighborhood watch that goes from polygon to polygon, across lines.
struct Walk {
  std::uint32_t triangle;
  Prism prism;     // over it
  int looked = 1;  // triangles
  Four foot{};     // of h, once the prism holds it; x, y, z
};

/// The common search: to the triangle whose prism holds h, as neighborhoodWatch() gets there, bit for bit. False where
/// it is not as simple as that: at a vertex, a boundary, a triangle without area, or where the search ends on a line.
[[nodiscard, gnu::always_inline]] inline bool crossLines(const Surface& surface, Vec3 h, SearchPath* path,
                                                         Walk& walk) noexcept {
  const FourVec3 each = all(h);
  double nearest = std::numeric_limits<double>::infinity();  // squared distance, m^2
  while (!walk.prism.holds()) [[unlikely]] {
      const Prism::OnEdges on = walk.prism.onEdges(each);
      const int k = on.nearest(walk.prism.beyond());
      if (on.atCorner(k) || !(on.squaredDistance[k] < nearest) || walk.looked == kMostCrossed) return false;
      nearest = on.squaredDistance[k];
      if (path != nullptr) path->add(on.point[k], walk.triangle);
      walk.triangle = surface.triangle(walk.triangle).neighbour(k);
      if (walk.triangle == kNoTriangle || surface.triangle(walk.triangle).zeroArea()) return false;
      walk.prism = Prism(surface.triangle(walk.triangle), each);
      ++walk.looked;
    }
  walk.foot = walk.prism.foot(four(h));
  const Vec3 foot = vec3(walk.foot);
  if (path != nullptr) path->add(foot, walk.triangle);
  return squaredLength(h - foot) < nearest;
}

}  // namespace haptics

#pragma once

#include "haptic_server/engine/contact/fast_path/cached_triangle.h"
#include "haptic_server/engine/contact/fast_path/triangle_cache.h"
#include "haptic_server/engine/contact/triangle_step.h"

namespace haptics {

/// From the polygon that holds the IHIP to the one that holds the HIP at the end of its path (from, to: body frame,
/// metres), across lines only. Null when the general tick has to decide.
/// @param own  Becomes the triangle, where the cache does not hold it; may be `first`.
/// @param[in,out] end  Of the HIP at the end, beyond the polygon.
/// @param most  Polygons to look at; they are counted in `looked`.
/// @param cache  May be null.
[[nodiscard, gnu::always_inline]] inline const CachedTriangle* walkTriangles(
    const CollisionMesh& surface, const CachedTriangle& first, CachedTriangle& own, const Vec3x4& from,
    const Vec3x4& to, int side, int most, Prism::Coordinates& end, int& looked, const TriangleCache* cache) noexcept {
  const CachedTriangle* at = &first;
  Prism::Coordinates start = at->prism.coordinates(from);
  TriangleStep step;
  std::uint32_t triangle = kNoTriangle;
  do {
    if (looked >= most) return nullptr;
    ++looked;
    step.leave(start, end, step.enters);
    triangle = at->neighbour[static_cast<std::size_t>(step.edge)];
    if (triangle == kNoTriangle) return nullptr;
    const std::uint32_t common = at->vertex[static_cast<std::size_t>(nextCorner(step.edge))];
    at = cache != nullptr ? cache->find(surface, triangle) : nullptr;
    if (at == nullptr) {
      own.clear();  // until it is whole
      own.take(surface.triangle(triangle));
      at = &own;
    }
    step.across = at->cornerOf(common);
    start = at->prism.coordinates(from);
    end = at->prism.coordinates(to);
    if (step.across < 0 || !step.enter(start, end, side) || step.enters >= 1) return nullptr;
  } while (end.beyond() != 0);
  if (at == &own) own.deriveFromPrism(surface, triangle);
  return at;
}

}  // namespace haptics

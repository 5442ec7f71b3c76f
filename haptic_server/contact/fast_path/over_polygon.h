#pragma once

#include "haptic_server/contact/fast_path/held_polygon.h"
#include "haptic_server/contact/fast_path/known_polygons.h"
#include "haptic_server/contact/hop.h"

namespace haptics {

/// From the polygon that holds the IHIP to the one that holds the HIP at the end of its way (from, to: body frame, metres),
/// by polygons only. Null when there is more to it.
/// @param own  Becomes what is not known; may be `first`.
/// @param[in,out] end  Of the HIP at the end, beyond the polygon.
/// @param most  Polygons to look at; they are counted in `looked`.
/// @param known  May be null.
[[nodiscard, gnu::always_inline]] inline const HeldPolygon* hopOverPolygons(
    const Surface& surface, const HeldPolygon& first, HeldPolygon& own, const FourVec3& from, const FourVec3& to,
    int side, int most, Prism::Place& end, int& looked, const KnownPolygons* known) noexcept {
  const HeldPolygon* at = &first;
  Prism::Place start = at->prism.place(from);
  Hop hop;
  std::uint32_t triangle = kNoTriangle;
  do {
    if (looked == most) return nullptr;
    ++looked;
    hop.leave(start, end, hop.enters);
    triangle = at->neighbour[static_cast<std::size_t>(hop.edge)];
    if (triangle == kNoTriangle) return nullptr;
    const std::uint32_t common = at->vertex[static_cast<std::size_t>(nextCorner(hop.edge))];
    at = known != nullptr ? known->find(surface, triangle) : nullptr;
    if (at == nullptr) {
      own.forget();  // until it is whole
      own.take(surface.triangle(triangle));
      at = &own;
    }
    hop.across = at->cornerOf(common);
    start = at->prism.place(from);
    end = at->prism.place(to);
    if (hop.across < 0 || !hop.enter(start, end, side) || hop.enters >= 1) return nullptr;
  } while (end.beyond() != 0);
  if (at == &own) own.describe(surface, triangle);
  return at;
}

}  // namespace haptics

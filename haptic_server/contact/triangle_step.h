#pragma once

#include <algorithm>
#include <bit>

#include "haptic_server/geometry/closest_point.h"

namespace haptics {

/// A half space that the HIP is within at value 0 and more: when does it go out?
[[nodiscard]] inline double timeWithin(double atFrom, double atTo) noexcept {
  if (atTo >= atFrom || atTo >= 0) return 1;
  return std::max(atFrom, 0.0) / (atFrom - atTo);
}

/// From one polygon to the next, under the HIP's way in a tick. Where the HIP is against a plane is linear in time, so
/// that the two ends of the way tell of all between. Times are fractions of the tick.
struct TriangleStep {
  double leaves = 0;  ///< The prism.
  double enters = 0;  ///< The next one; later than that where the line between lies in a valley.
  int edge = 0;       ///< That is crossed, of the polygon that is left.
  int across = 0;     ///< The same edge, of the next one.

  /// Where the HIP, which ends beyond the prism, leaves it: not before `now`, at the first of the edges that it goes beyond.
  [[gnu::always_inline]] void leave(const Prism::Coordinates& start, const Prism::Coordinates& end,
                                    double now) noexcept {
    // As timeWithin(), but that no edge is crossed within which the end is.
    const Mask4 comesBack = end.scaledDistance >= start.scaledDistance;
    const Double4 way = select(comesBack, broadcast(1), maximum(broadcast(0), start.scaledDistance));
    const Double4 whole = select(comesBack, broadcast(1), start.scaledDistance - end.scaledDistance);
    const Double4 times = select(end.scaledDistance > broadcast(0), broadcast(2), way / whole);
    leaves = std::max(now, std::min(std::min(times[0], times[1]), times[2]));
    const unsigned edges = end.beyond();
    const unsigned others = edges & (edges - 1);
    edge = std::countr_zero(edges);
    if (others != 0) {  // by products: the next polygon need not wait for a quotient
      const unsigned notAfterNext = (way * rotateLanes(whole) <= rotateLanes(way) * whole).bits();
      const bool isFirst = (edge == 0 && others == 4) ? (notAfterNext & 4) == 0 : (notAfterNext >> edge & 1) != 0;
      edge = isFirst ? edge : std::countr_zero(others);
    }
  }

  /// Where the HIP, which leaves the polygon before this one, enters the prism. False when it does so beyond another
  /// edge as well, or outside of the surface.
  [[nodiscard, gnu::always_inline]] bool enter(const Prism::Coordinates& start, const Prism::Coordinates& end,
                                               int side) noexcept {
    const auto at = [&](double time) noexcept {
      return Prism::Coordinates{start.scaledDistance + (end.scaledDistance - start.scaledDistance) * broadcast(time)};
    };
    enters = leaves;
    Prism::Coordinates place = at(enters);
    unsigned beyond = place.beyond();
    if ((beyond >> across & 1) != 0) [[unlikely]] {  // a valley: the line holds the IHIP for a while
      enters = std::max(leaves, timeWithin(-start.scaledDistance[across], -end.scaledDistance[across]));
      place = at(enters);
      beyond = place.beyond();
    }
    return !place.isOutside(side) && (beyond & ~(1U << across)) == 0;
  }
};

}  // namespace haptics

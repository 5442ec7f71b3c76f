#pragma once

#include <algorithm>
#include <bit>

#include "haptic_server/engine/geometry/closest_point.h"

namespace haptics {

/// The time at which the HIP leaves a half space, which it is within at value 0 and more.
[[nodiscard]] inline double timeWithin(double atFrom, double atTo) noexcept {
  if (atTo >= atFrom || atTo >= 0) return 1;
  return std::max(atFrom, 0.0) / (atFrom - atTo);
}

/// A step from one polygon to the next, under the HIP's path in a tick. The HIP's distance from a plane is linear in
/// time, and follows from the two ends of the path. Times are fractions of the tick.
struct TriangleStep {
  double leaves = 0;  ///< Time at which the HIP leaves the prism;
  double enters = 0;  ///< and enters the next one; later where the line between lies in a valley.
  int edge = 0;       ///< The edge that is crossed, in the polygon that is left;
  int across = 0;     ///< and in the next one.

  /// Of a HIP that ends beyond the prism: sets the time at which it leaves, not before `now`, and the edge.
  [[gnu::always_inline]] void leave(const Prism::Coordinates& start, const Prism::Coordinates& end,
                                    double now) noexcept {
    // As timeWithin(), but for edges within which the end is: none of them is crossed.
    const Mask4 comesBack = end.scaledDistance >= start.scaledDistance;
    const Double4 distanceInside = select(comesBack, broadcast(1), maximum(broadcast(0), start.scaledDistance));
    const Double4 approach = select(comesBack, broadcast(1), start.scaledDistance - end.scaledDistance);
    const Double4 times = select(end.scaledDistance > broadcast(0), broadcast(2), distanceInside / approach);
    leaves = std::max(now, std::min(std::min(times[0], times[1]), times[2]));
    const unsigned edges = end.beyond();
    const unsigned others = edges & (edges - 1);
    edge = std::countr_zero(edges);
    if (others != 0) {  // by products: the next polygon need not wait for a quotient
      const unsigned notAfterNext =
          (distanceInside * rotateLanes(approach) <= rotateLanes(distanceInside) * approach).bits();
      const bool isFirst = (edge == 0 && others == 4) ? (notAfterNext & 4) == 0 : (notAfterNext >> edge & 1) != 0;
      edge = isFirst ? edge : std::countr_zero(others);
    }
  }

  /// Sets the time at which the HIP enters the prism of the next polygon. False when it does so beyond another edge as
  /// well, or outside of the surface.
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

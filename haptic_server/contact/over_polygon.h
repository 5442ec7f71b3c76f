#pragma once

#include <algorithm>
#include <bit>

#include "haptic_server/contact/neighborhood_watch.h"
#include "haptic_server/geometry/neighbours.h"

namespace haptics {

/// A half space that the HIP is within at value 0 and more: when does it go out?
[[nodiscard]] inline double timeWithin(double atFrom, double atTo) noexcept {
  if (atTo >= atFrom || atTo >= 0) return 1;
  return std::max(atFrom, 0.0) / (atFrom - atTo);
}

/// A polygon under the HIP's way of a tick (body frame, metres): where along the way the HIP is in its prism. Where the
/// HIP is against a plane is linear in time, so that the two ends of the way tell of all between.
class OverPolygon {
 public:
  OverPolygon(const Surface& surface, std::uint32_t triangle, const FourVec3& to) noexcept
      : triangle_(triangle), prism_(surface.triangle(triangle)), end_(prism_.place(to)) {}

  /// From this polygon to the next one. Times are fractions of the tick.
  struct Hop {
    double leaves = 0;  ///< The prism.
    double enters = 0;  ///< The next one; later than that where the line between lies in a valley.
    int edge = 0;       ///< That is crossed, of this polygon.
    int across = 0;     ///< The same edge, of the next one.
  };

  [[nodiscard]] std::uint32_t triangle() const noexcept { return triangle_; }
  /// Of the HIP at the start of the way, for leave() and enter().
  [[nodiscard]] Prism::Place start(const FourVec3& from) const noexcept { return prism_.place(from); }
  /// At the end of the way the HIP is in the prism.
  [[nodiscard]] bool holdsEnd() const noexcept { return end_.beyond() == 0; }
  [[nodiscard]] bool endsOutside(int side) const noexcept { return (end_.height >= 0) == (side > 0); }
  /// Of the HIP at the end.
  [[nodiscard]] Four endFoot(Four to) const noexcept { return prism_.foot(to, end_.height); }
  [[nodiscard]] Vec3 footOf(Vec3 h) const noexcept { return vec3(prism_.foot(four(h), prism_.place(all(h)).height)); }
  [[nodiscard]] Four unitNormal() const noexcept { return prism_.unitNormal(); }

  /// Where the HIP, which is not held at the end, leaves the prism: not before `now`. False at a boundary.
  [[nodiscard, gnu::always_inline]] bool leave(const Surface& surface, const Prism::Place& start, double now,
                                               Hop& hop) const noexcept {
    unsigned beyond = end_.beyond();
    hop.edge = std::countr_zero(beyond);
    hop.leaves = timeWithin(start.inside[hop.edge], end_.inside[hop.edge]);
    for (beyond &= beyond - 1; beyond != 0; beyond &= beyond - 1) {
      const int edge = std::countr_zero(beyond);
      const double leaves = timeWithin(start.inside[edge], end_.inside[edge]);
      if (leaves < hop.leaves) {
        hop.leaves = leaves;
        hop.edge = edge;
      }
    }
    hop.leaves = std::max(now, hop.leaves);
    hop.across = sameLineAcross(surface, triangle_, hop.edge);
    return hop.across >= 0;
  }

  /// Where the HIP, which leaves the polygon before this one, enters the prism. False when it does so beyond another
  /// edge as well, or outside of the surface.
  [[nodiscard, gnu::always_inline]] bool enter(const Prism::Place& start, int side, Hop& hop) const noexcept {
    const auto at = [&](double time) noexcept {
      return Prism::Place{start.inside + (end_.inside - start.inside) * all(time),
                          start.height + (end_.height - start.height) * time};
    };
    hop.enters = hop.leaves;
    Prism::Place place = at(hop.enters);
    if ((place.beyond() >> hop.across & 1) != 0) {  // a valley: the line holds the IHIP for a while
      hop.enters = std::max(hop.leaves, timeWithin(-start.inside[hop.across], -end_.inside[hop.across]));
      place = at(hop.enters);
    }
    const bool isOutside = (place.height >= 0) == (side > 0);
    return !isOutside && (place.beyond() & ~(1U << hop.across)) == 0;
  }

 private:
  std::uint32_t triangle_;
  Prism prism_;
  Prism::Place end_;
};

/// The polygon that holds the HIP at the end of its way.
struct HoldingPolygon {
  std::uint32_t triangle;
  bool endsOutside;  ///< Of the surface.
  Four foot;         ///< Of the HIP.
  Four unitNormal;
};

/// From a polygon to the one that holds the HIP at the end, by polygons only. False when there is more to it. `from()`
/// is the start of the way, asked for when the polygon does not hold the end. Looks at no more than `most` polygons, and
/// counts them in `looked`. One loop for the polygon that holds the end and for those that do not: with cold caches a
/// change of polygon then waits for little more code.
template <class From>
[[nodiscard, gnu::always_inline]] inline bool goOverPolygons(const Surface& surface, std::uint32_t triangle, From from,
                                                             Vec3 to, int side, int most, HoldingPolygon& holding,
                                                             int& looked) noexcept {
  OverPolygon::Hop hop;
  const FourVec3 end = all(to);
  for (bool hopped = false;; hopped = true) {
    if (looked == most) return false;
    ++looked;
    const OverPolygon over(surface, triangle, end);
    if (hopped || !over.holdsEnd()) [[unlikely]] {
      const Prism::Place start = over.start(all(from()));
      if (hopped && (!over.enter(start, side, hop) || hop.enters >= 1)) return false;
      if (!over.holdsEnd()) {
        if (!over.leave(surface, start, hop.enters, hop)) return false;
        triangle = surface.triangle(triangle).neighbour(hop.edge);
        continue;
      }
    }
    holding = {triangle, over.endsOutside(side), over.endFoot(four(to)), over.unitNormal()};
    return true;
  }
}

}  // namespace haptics

#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "haptic_server/geometry/lanes.h"
#include "haptic_server/geometry/triangle_record.h"

namespace haptics {

/// The geometric primitives of the paper's database (3.1).
enum class Feature : std::uint8_t { kPolygon, kLine, kVertex };

/// The point of a triangle that is closest to some h, and the primitive that holds it.
struct Foot {
  std::uint32_t triangle = kNoTriangle;
  Feature feature = Feature::kPolygon;
  std::uint8_t index = 0;                                            ///< Of the line or vertex in the triangle.
  Vec3 point{0};                                                     ///< Object frame, metres.
  double squaredDistance = std::numeric_limits<double>::infinity();  ///< |h - point|^2, m^2.
};

/// h (object frame, metres) against a triangle's plane and against the planes through its edges along the normal.
class Prism {
 public:
  Prism(const TriangleRecord& r, const FourVec3& h) noexcept
      : corner_{firstThree(r.rows[0]), firstThree(r.rows[1]), firstThree(r.rows[2])},
        edge_(following(corner_) - corner_),
        toH_(h - corner_),
        // Of edge 2 and the one that follows, edge 0: areaNormal() to the bit.
        normal_(allOf<2>(cross(edge_, following(edge_)))),
        squaredNormal_(squaredLength(normal_)),
        height_(dot(normal_, toH_)),
        beyond_(~(dot(cross(normal_, edge_), toH_) > all(0)).bits() & 7) {}

  [[nodiscard]] double squaredNormal() const noexcept { return squaredNormal_[0]; }
  /// Of h above the plane, times the length of the normal; m^3.
  [[nodiscard]] double height() const noexcept { return height_[0]; }
  /// Bit k: h is on the plane through edge k or on its outer side.
  [[nodiscard]] unsigned beyond() const noexcept { return beyond_; }
  /// h is strictly within all three.
  [[nodiscard]] bool holds() const noexcept { return beyond_ == 0; }
  /// Of h, onto the plane; x, y, z.
  [[nodiscard]] Four foot(Four h) const noexcept { return h - xyz(normal_) * (allOf<0>(height_) / squaredNormal_); }
  [[nodiscard]] Four unitNormal() const noexcept { return xyz(normal_) / all(std::sqrt(squaredNormal())); }

  /// The points of the edges that are closest to h. Ends go to the vertices.
  struct OnEdges {
    FourVec3 point;
    Four squaredDistance;
    unsigned atStart;  ///< Bit k: the point of edge k is its corner k.
    unsigned atEnd;    ///< Bit k: the point of edge k is its corner k + 1.

    /// Of these edges, one at least, the nearest; the first one of equals.
    [[nodiscard]] int nearest(unsigned edges) const noexcept {
      int best = std::countr_zero(edges);
      for (unsigned rest = edges & (edges - 1); rest != 0; rest &= rest - 1) {
        const int k = std::countr_zero(rest);
        if (squaredDistance[k] < squaredDistance[best]) best = k;
      }
      return best;
    }
    [[nodiscard]] bool atCorner(int k) const noexcept { return ((atStart | atEnd) >> k & 1) != 0; }
  };
  [[nodiscard]] OnEdges onEdges(const FourVec3& h) const noexcept {
    const Four along = dot(toH_, edge_);
    const Four end = squaredLength(edge_);
    const FourTruths atStart = along <= all(0);
    const FourTruths atEnd = end <= along;
    const FourVec3 within = corner_ + edge_ * (along / end);
    const FourVec3 point = select(atStart, corner_, select(atEnd, following(corner_), within));
    return {point, squaredLength(h - point), atStart.bits(), atEnd.bits()};
  }

 private:
  FourVec3 corner_;
  FourVec3 edge_;
  FourVec3 toH_;  // from each corner
  FourVec3 normal_;
  Four squaredNormal_;
  Four height_;  // the first
  unsigned beyond_;
};

/// Closest point of the triangle to h (object frame, metres). Ties go to the primitive of lower dimension.
///
/// Tests h against the prism over the triangle rather than by products of dot products (Ericson, Real-Time Collision
/// Detection, 5.1.5): the error is then of the order of the distance over the triangle's width, not of its square,
/// which a sliver needs. The closest point lies on an edge that h is beyond, so only those are looked at.
[[nodiscard]] inline Foot closestOn(const TriangleRecord& record, std::uint32_t triangle, Vec3 h) noexcept {
  const FourVec3 each = all(h);
  const Prism prism(record, each);
  if (prism.holds()) {
    const Vec3 point = vec3(prism.foot(four(h)));
    return {triangle, Feature::kPolygon, 0, point, squaredLength(h - point)};
  }
  const Prism::OnEdges on = prism.onEdges(each);
  const int k = on.nearest(prism.beyond());
  const int index = (on.atStart >> k & 1) != 0 ? k : (on.atEnd >> k & 1) != 0 ? nextCorner(k) : k;
  const Feature feature = on.atCorner(k) ? Feature::kVertex : Feature::kLine;
  return {triangle, feature, static_cast<std::uint8_t>(index), on.point[k], on.squaredDistance[k]};
}

}  // namespace haptics

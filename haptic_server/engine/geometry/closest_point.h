#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "haptic_server/engine/geometry/simd.h"
#include "haptic_server/engine/geometry/triangle_record.h"

namespace haptics {

/// The geometric primitives of the paper's database (3.1).
enum class Feature : std::uint8_t { kPolygon, kLine, kVertex };
[[nodiscard]] constexpr Feature lastOf(Feature) noexcept { return Feature::kVertex; }

/// The point of a triangle that is closest to some h, and the primitive that holds it.
struct ClosestPoint {
  std::uint32_t triangle = kNoTriangle;
  Feature feature = Feature::kPolygon;
  std::uint8_t index = 0;                                            ///< Of the line or vertex in the triangle.
  Vec3 point{0};                                                     ///< Object frame, metres.
  double squaredDistance = std::numeric_limits<double>::infinity();  ///< |h - point|^2, m^2.
};

/// A triangle's plane and the planes through its edges along the normal, for points of the object frame (metres): four
/// planes at work at once.
class Prism {
 public:
  Prism() noexcept = default;  ///< Of nothing, beyond which everything is.
  [[gnu::always_inline]] explicit Prism(const TriangleRecord& r) noexcept
      : corner_{threeAndFirst(r.rows[0]), threeAndFirst(r.rows[1]), threeAndFirst(r.rows[2])} {
    const Vec3x4 edge = edges();
    // from edge 2 and the next, edge 0: bit-identical with areaNormal()
    const Vec3x4 normal = broadcastLane<2>(cross(edge, rotateLanes(edge)));
    plane_ = threeAndThird(cross(normal, edge), normal);
  }

  /// Where some h is.
  struct Coordinates {
    /// Within the plane through edge k, times the lengths of normal and edge (m^4); last, the height.
    Double4 scaledDistance;

    /// Bit k: h is on the plane through edge k or on its outer side.
    [[nodiscard]] unsigned beyond() const noexcept { return ~(scaledDistance > broadcast(0)).bits() & 7; }
    /// Above the triangle's plane, times the length of the normal; m^3.
    [[nodiscard]] double height() const noexcept { return scaledDistance[3]; }
    /// On the plane counts as outside; `side` is -1 for the back of a sheet.
    [[nodiscard]] bool isOutside(int side) const noexcept { return (height() >= 0) == (side > 0); }
  };
  [[nodiscard, gnu::always_inline]] Coordinates coordinates(const Vec3x4& h) const noexcept {
    return {dot(plane_, h - corner_)};
  }

  /// Of the planes through the edges, inward, and of the triangle.
  [[nodiscard]] const Vec3x4& normals() const noexcept { return plane_; }
  /// As long as twice the triangle's area; x, y, z.
  [[nodiscard]] Double4 normal() const noexcept { return xyzOfFourth(plane_); }
  [[nodiscard]] double squaredNormal() const noexcept { return squaredLength(vec3(normal())); }
  /// Projects an h of that height onto the plane; x, y, z.
  [[nodiscard]] Double4 foot(Double4 h, double height) const noexcept {
    return h - normal() * broadcast(height * (1 / squaredNormal()));
  }
  [[nodiscard]] Double4 unitNormal() const noexcept { return normal() / broadcast(std::sqrt(squaredNormal())); }
  /// Distance of an h of that height from the plane; m.
  [[nodiscard]] double distance(double height) const noexcept {
    return std::abs(height) * (1 / std::sqrt(squaredNormal()));
  }

  /// The points of the edges that are closest to h. Ends go to the vertices.
  struct OnEdges {
    Vec3x4 point;
    Double4 squaredDistance;
    unsigned atStart;  ///< Bit k: the point of edge k is its corner k.
    unsigned atEnd;    ///< Bit k: the point of edge k is its corner k + 1.

    /// The nearest of these edges (one at least); the first of equals.
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
  [[nodiscard]] OnEdges onEdges(const Vec3x4& h) const noexcept {
    const Vec3x4 edge = edges();
    const Double4 along = dot(h - corner_, edge);
    const Double4 end = squaredLength(edge);
    const Mask4 atStart = along <= broadcast(0);
    const Mask4 atEnd = end <= along;
    const Vec3x4 within = corner_ + edge * (along / end);
    const Vec3x4 point = select(atStart, corner_, select(atEnd, rotateLanes(corner_), within));
    return {point, squaredLength(h - point), atStart.bits(), atEnd.bits()};
  }

 private:
  [[nodiscard]] Vec3x4 edges() const noexcept { return rotateLanes(corner_) - corner_; }

  Vec3x4 corner_{};  // last, the first one again
  Vec3x4 plane_{};   // normals, inward; last, that of the triangle
};

/// Distance of h from the plane of a triangle; object frame, metres.
[[nodiscard]] inline double distanceFrom(const TriangleRecord& record, Vec3 h) noexcept {
  const Prism prism(record);
  return prism.distance(prism.coordinates(broadcast(h)).height());
}

/// Closest point of the triangle to h (object frame, metres). Ties go to the primitive of lower dimension.
///
/// Tests h against the prism over the triangle rather than by products of dot products (Ericson, Real-Time Collision
/// Detection, 5.1.5): the error is then of the order of the distance over the triangle's width, not of its square,
/// which a sliver needs. The closest point lies on an edge that h is beyond, so only those are looked at.
[[nodiscard]] inline ClosestPoint closestOn(const TriangleRecord& record, std::uint32_t triangle, Vec3 h) noexcept {
  const Vec3x4 each = broadcast(h);
  const Prism prism(record);
  const Prism::Coordinates place = prism.coordinates(each);
  const unsigned beyond = place.beyond();
  if (beyond == 0) {
    const Vec3 point = vec3(prism.foot(toDouble4(h), place.height()));
    return {triangle, Feature::kPolygon, 0, point, squaredLength(h - point)};
  }
  const Prism::OnEdges on = prism.onEdges(each);
  const int k = on.nearest(beyond);
  const int index = (on.atStart >> k & 1) != 0 ? k : (on.atEnd >> k & 1) != 0 ? nextCorner(k) : k;
  const Feature feature = on.atCorner(k) ? Feature::kVertex : Feature::kLine;
  return {triangle, feature, static_cast<std::uint8_t>(index), on.point[k], on.squaredDistance[k]};
}

}  // namespace haptics

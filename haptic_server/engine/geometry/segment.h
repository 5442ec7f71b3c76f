#pragma once

#include <cmath>
#include <cstdint>

#include "haptic_server/engine/geometry/closest_point.h"
#include "haptic_server/engine/geometry/float_box.h"
#include "haptic_server/engine/geometry/simd.h"
#include "haptic_server/engine/geometry/triangle_record.h"

namespace haptics {

/// Where a segment enters a surface.
struct Crossing {
  std::uint32_t triangle = kNoTriangle;
  double time = 1;        ///< Fraction of the segment, 0 to 1.
  int side = 1;           ///< 1 when entered from the triangle's outside, -1 from its back (sheets only).
  bool isBeside = false;  ///< It passes the plane within a rim beside the triangle (RimmedSegment).

  explicit operator bool() const noexcept { return triangle != kNoTriangle; }
};

/// A segment as seen along itself (Woop, Benthin and Wald, Watertight Ray/Triangle Intersection, 2013). Every vertex is
/// projected by the same arithmetic for every triangle that uses it and the tests are made on the projections, so that
/// neighbours agree on the side of each shared edge and around each shared vertex: nothing slips between them. Rests on
/// products that are not fused (-ffp-contract=off). Deviations: double throughout, and no fallback for edge functions
/// that are zero, because a point on an edge counts as inside of both neighbours; the three corners at once, and before
/// the plane, which near a surface the segment goes through for most triangles.
class Segment {
 public:
  Segment(Vec3 from, Vec3 to) noexcept : from_(from), to_(to) {
    const Vec3 d = to - from;
    const Vec3 size = glm::abs(d);
    const int depth = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    const auto along = [&](int axis) noexcept { return Axis{static_cast<std::size_t>(axis), broadcast(from[axis])}; };
    depth_ = along(depth);
    across_ = along(nextCorner(depth));
    up_ = along(previousCorner(depth));
    slopeAcross_ = broadcast(d[nextCorner(depth)] / d[depth]);
    slopeUp_ = broadcast(d[previousCorner(depth)] / d[depth]);
  }

  /// Does it enter the triangle: from on or above its plane to below? A sheet (`twoSided`) is entered from below as
  /// well. On the plane counts as above at both ends and for both sides, so that a path of several segments that meet
  /// on the plane enters exactly once. Returns true with time and side set.
  [[nodiscard]] bool enters(const TriangleRecord& r, bool twoSided, Crossing& crossing) const noexcept {
    return passes(r) && entersPlane(r, twoSided, crossing);
  }

 protected:
  /// The triangle's.
  [[nodiscard]] bool entersPlane(const TriangleRecord& r, bool twoSided, Crossing& crossing) const noexcept {
    const Vec3 a = r.corner(0);
    const Vec3 normal = r.areaNormal();
    const double height0 = glm::dot(normal, from_ - a);
    const double height1 = glm::dot(normal, to_ - a);
    const bool down = height0 >= 0 && height1 < 0;
    const bool up = twoSided && height0 < 0 && height1 >= 0;
    if (!down && !up) return false;
    crossing.time = height0 / (height0 - height1);
    crossing.side = down ? 1 : -1;
    return true;
  }
  [[nodiscard]] Vec3 at(double time) const noexcept { return from_ + time * (to_ - from_); }
  /// Does its line meet the triangle?
  [[nodiscard]] bool passes(const TriangleRecord& r) const noexcept {
    const Double4 depth = depth_.of(r);
    const Double4 across = across_.of(r) - slopeAcross_ * depth;
    const Double4 up = up_.of(r) - slopeUp_ * depth;
    const Double4 edge = across * rotateLanes(up) - up * rotateLanes(across);
    constexpr unsigned kAll = 7;
    return ((edge >= broadcast(0)).bits() & kAll) == kAll || ((edge <= broadcast(0)).bits() & kAll) == kAll;
  }

 private:
  struct Axis {
    std::size_t row = 0;  ///< Of a record.
    Double4 from{};       ///< Coordinate of the start, metres.

    [[nodiscard]] Double4 of(const TriangleRecord& r) const noexcept { return threeAndFirst(r.rows[row]) - from; }
  };
  Vec3 from_;
  Vec3 to_;
  Axis depth_;
  Axis across_;
  Axis up_;
  Double4 slopeAcross_;
  Double4 slopeUp_;
};

/// A segment that enters a triangle, too, where it passes its plane beside it by no more than `rim_m`: two surfaces with a
/// gap between them that is no wider than their rims let nothing through.
class RimmedSegment : public Segment {
 public:
  RimmedSegment(Vec3 from, Vec3 to, double rim_m) noexcept
      : Segment(from, to),
        rim_m_(rim_m),
        reach_(FloatBox(lanes(Vec3f(glm::min(from, to))), lanes(Vec3f(glm::max(from, to))))
                   .padded(static_cast<float>(kReach * rim_m))) {}

  [[nodiscard]] bool enters(const TriangleRecord& r, bool twoSided, Crossing& crossing) const noexcept {
    if (!reach_.overlaps(FloatBox(r)) || !entersPlane(r, twoSided, crossing)) return false;
    crossing.isBeside = !passes(r);
    return !crossing.isBeside || closestOn(r, 0, at(crossing.time)).squaredDistance <= rim_m_ * rim_m_;
  }

 private:
  static constexpr double kReach = 4;  // rims: also what rounding to floats does
  double rim_m_;
  FloatBox reach_;
};

}  // namespace haptics

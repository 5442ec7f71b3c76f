#pragma once

#include <cmath>
#include <cstdint>

#include "haptic_server/geometry/triangle_record.h"

namespace haptics {

/// Where a segment enters a surface.
struct Crossing {
  std::uint32_t triangle = kNoTriangle;
  double time = 1;  ///< Fraction of the segment, 0 to 1.
  int side = 1;     ///< 1 when entered from the triangle's outside, -1 from its back (sheets only).

  explicit operator bool() const noexcept { return triangle != kNoTriangle; }
};

/// A segment as seen along itself (Woop, Benthin and Wald, Watertight Ray/Triangle Intersection, 2013). Every vertex is
/// projected by the same arithmetic for every triangle that uses it and the tests are made on the projections, so that
/// neighbours agree on the side of each shared edge and around each shared vertex: nothing slips between them. Rests on
/// products that are not fused (-ffp-contract=off). Deviation: double throughout, and no fallback for edge functions
/// that are zero, because a point on an edge counts as inside of both neighbours.
class Segment {
 public:
  Segment(Vec3 from, Vec3 to) noexcept : from_(from), to_(to) {
    const Vec3 d = to - from;
    const Vec3 size = glm::abs(d);
    depth_ = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    across_ = nextCorner(depth_);
    up_ = previousCorner(depth_);
    slopeAcross_ = d[across_] / d[depth_];
    slopeUp_ = d[up_] / d[depth_];
  }

  /// Does it enter the triangle: from on or above its plane to below? A sheet (`twoSided`) is entered from below as
  /// well. On the plane counts as above at both ends and for both sides, so that a path of several segments that meet
  /// on the plane enters exactly once. Returns true with time and side set.
  [[nodiscard]] bool enters(const TriangleRecord& r, bool twoSided, Crossing& crossing) const noexcept {
    const Vec3 a = r.corner(0);
    const Vec3 normal = r.areaNormal();
    const double height0 = glm::dot(normal, from_ - a);
    const double height1 = glm::dot(normal, to_ - a);
    const bool down = height0 >= 0 && height1 < 0;
    const bool up = twoSided && height0 < 0 && height1 >= 0;
    if (!down && !up) return false;
    const Point pa = project(a);
    const Point pb = project(r.corner(1));
    const Point pc = project(r.corner(2));
    const double ab = pa.across * pb.up - pa.up * pb.across;
    const double bc = pb.across * pc.up - pb.up * pc.across;
    const double ca = pc.across * pa.up - pc.up * pa.across;
    const bool inside = (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
    if (!inside) return false;
    crossing.time = height0 / (height0 - height1);
    crossing.side = down ? 1 : -1;
    return true;
  }

 private:
  struct Point {
    double across, up;
  };
  [[nodiscard]] Point project(Vec3 v) const noexcept {
    const double depth = v[depth_] - from_[depth_];
    return {v[across_] - from_[across_] - slopeAcross_ * depth, v[up_] - from_[up_] - slopeUp_ * depth};
  }

  Vec3 from_;
  Vec3 to_;
  int depth_;
  int across_;
  int up_;
  double slopeAcross_;
  double slopeUp_;
};

}  // namespace haptics

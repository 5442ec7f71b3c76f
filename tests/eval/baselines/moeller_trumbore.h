#pragma once

#include "haptic_server/engine/geometry/segment.h"

namespace haptics::eval {

/// Moeller and Trumbore, Fast, minimum storage ray/triangle intersection, 1997. Deviation: without its epsilon, 1e-6,
/// which would make it depend on the unit of length; in metres nothing smaller than a hand would ever be hit.
/// Interchangeable with the production Segment.
class MoellerTrumbore {
 public:
  MoellerTrumbore(Vec3 from, Vec3 to) noexcept : from_(from), way_(to - from) {}

  [[nodiscard]] bool enters(const TriangleRecord& r, bool twoSided, Crossing& crossing) const noexcept {
    const Vec3 edge1 = r.corner(1) - r.corner(0);
    const Vec3 edge2 = r.corner(2) - r.corner(0);
    const Vec3 p = glm::cross(way_, edge2);
    const double determinant = glm::dot(edge1, p);
    if (determinant == 0 || (determinant < 0 && !twoSided)) return false;
    const Vec3 s = from_ - r.corner(0);
    const double u = glm::dot(s, p) / determinant;
    if (u < 0 || u > 1) return false;
    const Vec3 q = glm::cross(s, edge1);
    const double v = glm::dot(way_, q) / determinant;
    if (v < 0 || u + v > 1) return false;
    const double time = glm::dot(edge2, q) / determinant;
    if (time < 0 || time > 1) return false;
    crossing.time = time;
    crossing.side = determinant > 0 ? 1 : -1;
    return true;
  }

 private:
  Vec3 from_;
  Vec3 way_;
};

}  // namespace haptics::eval

#pragma once

#include "haptic_server/geometry/triangle_record.h"

namespace haptics {

/// What each of the triangle's corners has of a point of its plane, on to which the point is projected; the sum is 1. Thirds
/// where it has no area.
[[nodiscard]] inline Vec3 barycentric(const TriangleRecord& r, Vec3 point) noexcept {
  const Vec3 a = r.corner(0), ab = r.corner(1) - a, ac = r.corner(2) - a, to = point - a;
  const Vec3 normal = glm::cross(ab, ac);
  const double area2 = squaredLength(normal);
  if (!(area2 > 0)) return Vec3(1.0 / 3);
  const double b = glm::dot(glm::cross(to, ac), normal) / area2;
  const double c = glm::dot(glm::cross(ab, to), normal) / area2;
  return {1 - b - c, b, c};
}

}  // namespace haptics

#pragma once

#include "common/maths/vec.h"

namespace haptics {

/// What each of a triangle's corners has of a point of its plane, on to which the point is projected; the sum is 1. Thirds
/// where it has no area.
[[nodiscard]] inline Vec3 barycentric(Vec3 a, Vec3 b, Vec3 c, Vec3 point) noexcept {
  const Vec3 ab = b - a, ac = c - a, to = point - a;
  const Vec3 normal = glm::cross(ab, ac);
  const double area2 = squaredLength(normal);
  if (!(area2 > 0)) return Vec3(1.0 / 3);
  const double ofB = glm::dot(glm::cross(to, ac), normal) / area2;
  const double ofC = glm::dot(glm::cross(ab, to), normal) / area2;
  return {1 - ofB - ofC, ofB, ofC};
}

}  // namespace haptics

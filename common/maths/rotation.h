#pragma once

#include <cmath>

#include "common/maths/elementary.h"
#include "common/maths/vec.h"

namespace haptics {

/// Of length 1, but for rounding; not for NaN.
[[nodiscard]] inline bool isRotation(Quat q) noexcept {
  constexpr double kTolerance = 1e-3;
  return std::abs(glm::dot(q, q) - 1) < kTolerance;
}

/// The rotation by a vector's length (rad) about it.
[[nodiscard]] inline Quat rotationBy(Vec3 angle) noexcept {
  const double squared = squaredLength(angle) / 4;
  // sin(x) / x; below, its series is exact to the last bit.
  const double half = std::sqrt(squared);
  const auto [sine, cosine] = elementary::sineCosine(half);
  const double sinc = squared < 1e-8 ? 1 - squared / 6 : sine / half;
  const Vec3 v = 0.5 * sinc * angle;
  return {cosine, v.x, v.y, v.z};
}

/// Its inverse: length at most pi.
[[nodiscard]] inline Vec3 rotationVector(Quat rotation) noexcept {
  if (rotation.w < 0) rotation = -rotation;
  const Vec3 v(rotation.x, rotation.y, rotation.z);
  const double sine = glm::length(v);
  if (sine < 1e-8) return 2.0 * v;
  return 2 * elementary::atan2(sine, rotation.w) / sine * v;
}

}  // namespace haptics

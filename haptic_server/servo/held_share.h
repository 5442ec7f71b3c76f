#pragma once

#include <algorithm>
#include <cmath>

#include "common/maths/vec.h"

namespace haptics {

/// Of the vector from the HIP to an IHIP that two or three surfaces hold, the part that the first one pushes: the vector
/// is the sum of their unit normals times these parts. `third` is zero when there are two. Not negative.
[[nodiscard]] inline double heldShare(Vec3 penetration_m, Vec3 first, Vec3 second, Vec3 third) noexcept {
  // Normals closer together than this do not tell their parts apart; all is then the first one's.
  constexpr double kLeastSquaredSine = 1e-4;
  double share = glm::dot(penetration_m, first);
  if (third != Vec3(0)) {
    const Vec3 others = glm::cross(second, third);
    const double volume = glm::dot(first, others);
    if (volume * volume > kLeastSquaredSine) return std::max(0.0, glm::dot(penetration_m, others) / volume);
  }
  const double cosine = glm::dot(first, second);
  const double squaredSine = 1 - cosine * cosine;
  if (squaredSine > kLeastSquaredSine) share = (share - cosine * glm::dot(penetration_m, second)) / squaredSine;
  return std::max(0.0, share);
}

}  // namespace haptics

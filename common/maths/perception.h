#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/maths/elementary.h"
#include "common/maths/vec.h"

namespace haptics {

inline constexpr double kForceThreshold_ratio = 0.07;    ///< Pang, Tan and Durlach 1991: 7 % of a force.
inline constexpr double kMinForceThreshold_N = 0.05;     ///< For forces so small that 7 % means nothing.
inline constexpr double kDirectionThreshold_deg = 18.4;  ///< Barbagli et al. 2006, with congruent vision.
inline constexpr double kFeltArtefactsFrom_Hz = 100;     ///< Above, small changes of force are felt as vibration.

[[nodiscard]] inline double angle_deg(Vec3 a, Vec3 b) {
  return elementary::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 / std::numbers::pi;
}

/// The error of a force in JNDs (just noticeable differences), of a hand with vision: 1 is just noticeable. Its magnitude and its
/// direction have thresholds of their own, so the difference of the magnitudes counts here, not that of the vectors: an
/// error of direction at its threshold would already be four times the magnitude's.
[[nodiscard]] inline double forceError_jnd(Vec3 felt_N, Vec3 ideal_N) {
  const double ideal = glm::length(ideal_N);
  const double magnitude =
      std::abs(glm::length(felt_N) - ideal) / std::max(kForceThreshold_ratio * ideal, kMinForceThreshold_N);
  if (felt_N == Vec3(0) || ideal_N == Vec3(0)) return magnitude;
  return std::max(magnitude, angle_deg(felt_N, ideal_N) / kDirectionThreshold_deg);
}

}  // namespace haptics

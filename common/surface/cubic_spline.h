#pragma once

#include <array>

namespace haptics {

/// Weights of four neighbouring coefficients in a uniform cubic B-spline at t in [0, 1) between the middle two.
struct SplineWeights {
  std::array<double, 4> value, slope, bend;  ///< The last two: derivatives by t.
};

[[nodiscard]] inline SplineWeights splineWeights(double t) noexcept {
  constexpr double kSixth = 1.0 / 6;
  const double s = 1 - t;
  return {
      {kSixth * s * s * s, kSixth * (t * t * (3 * t - 6) + 4), kSixth * (s * s * (3 * s - 6) + 4), kSixth * t * t * t},
      {-0.5 * s * s, 0.5 * t * (3 * t - 4), -0.5 * s * (3 * s - 4), 0.5 * t * t},
      {s, 3 * t - 2, 3 * s - 2, t}};
}

}  // namespace haptics

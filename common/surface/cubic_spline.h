#pragma once

#include <array>

namespace haptics {

/// Weights of four neighbouring coefficients in a uniform cubic B-spline at t in [0, 1) between the middle two.
struct SplineWeights {
  std::array<double, 4> value, slope, bend;  ///< The last two: derivatives by t.
};

[[nodiscard]] inline SplineWeights splineWeights(double t) noexcept {
  const double s = 1 - t;
  return {{s * s * s / 6, (t * t * (3 * t - 6) + 4) / 6, (s * s * (3 * s - 6) + 4) / 6, t * t * t / 6},
          {-s * s / 2, t * (3 * t - 4) / 2, -s * (3 * s - 4) / 2, t * t / 2},
          {s, 3 * t - 2, 3 * s - 2, t}};
}

}  // namespace haptics

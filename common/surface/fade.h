#pragma once

namespace haptics {

/// A function of one variable, at one place.
struct Ramp {
  double value, slope;
};

/// From 0 to 1 with first and second derivatives 0 at both ends (Perlin 2002).
[[nodiscard]] inline Ramp fade(double t) noexcept {
  return {t * t * t * (t * (t * 6 - 15) + 10), 30 * t * t * (t - 1) * (t - 1)};
}

}  // namespace haptics

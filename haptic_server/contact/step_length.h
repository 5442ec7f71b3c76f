#pragma once

namespace haptics {

/// Of a triangle's size (root of twice its area) that the HIP advances per step in contact, so that the search follows
/// the path that a slow hand would take. Larger jumps over creases; smaller costs time.
inline constexpr double kStepFraction = 0.5;

/// Is a motion of the HIP (squared, m^2) no more than a step over a triangle (square of twice its area, m^4)?
[[nodiscard]] constexpr bool inOneStep(double squaredStep, double squaredTwiceArea) noexcept {
  constexpr double kFraction2 = kStepFraction * kStepFraction;
  return squaredStep * squaredStep <= kFraction2 * kFraction2 * squaredTwiceArea;
}

}  // namespace haptics

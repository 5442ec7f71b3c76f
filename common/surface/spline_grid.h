#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace haptics {

/// Coefficients of a periodic bicubic B-spline, with one more column and row before and two after, so that the sixteen of
/// a place lie together.
struct SplineGrid {
  std::uint32_t width = 0, height = 0;  ///< Of the period.
  std::vector<float> coefficients;      ///< (width + 3) * (height + 3), row by row.

  /// The first of the four times four coefficients around the cell from (x, y) to (x + 1, y + 1).
  [[nodiscard]] const float* around(std::size_t x, std::size_t y) const noexcept {
    return coefficients.data() + y * stride() + x;
  }
  [[nodiscard]] std::size_t stride() const noexcept { return width + std::size_t{3}; }
};

/// The spline that passes through the samples (Unser, Aldroubi & Eden 1991: two recursive passes along each axis).
[[nodiscard]] SplineGrid interpolatingGrid(std::uint32_t width, std::uint32_t height, std::span<const float> samples);

/// Bounds of a spline's values.
struct SplineBounds {
  double lowest = 0, highest = 0;  ///< Never passed; reached within 0.5 % of the samples' range.
  double slope = 0;                ///< Largest |gradient| at corners and middles of up to 512 * 512 cells, per sample.
  double curvature = 0;            ///< Largest second derivative along any direction, at the same places.
};

[[nodiscard]] SplineBounds boundsOf(const SplineGrid& grid, std::span<const float> samples);

}  // namespace haptics

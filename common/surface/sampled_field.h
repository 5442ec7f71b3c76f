#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/error/error.h"
#include "common/maths/vec.h"
#include "common/surface/spline_grid.h"

namespace haptics {

inline constexpr std::uint32_t kMinFieldSide = 2, kMaxFieldSide = 4096;  ///< Samples.
inline constexpr float kMaxFieldValue = 1000;

/// Refused: a side out of range, as "width" or "height".
[[nodiscard]] Result<void> checkSides(std::uint32_t width, std::uint32_t height);

/// A dimensionless function of the plane, periodic, given at whole coordinates and interpolated by the bicubic B-spline
/// that passes through them: value, gradient and curvature are continuous. (The paper's Eqs. (5), (6) difference a
/// filtered image over some epsilon; here the filter's own gradient is taken, which is what epsilon -> 0 tends to.
/// A spline that only smooths would flatten a grating of 8 samples by a tenth; this one overshoots at an edge by up to
/// an eighth of it.) Immutable: at() from any thread.
class SampledField {
 public:
  /// \param samples row by row, the first row lowest, width * height of them. Refused: sides out of range, another number
  ///        of samples, values that are not finite or larger than kMaxFieldValue.
  [[nodiscard]] static Result<SampledField> make(std::uint32_t width, std::uint32_t height, std::vector<float> samples);

  struct Sample {
    double value;
    glm::dvec2 gradient;  ///< Per sample.
  };
  /// \param x, y in samples; finite.
  [[nodiscard]] Sample at(double x, double y) const noexcept;

  [[nodiscard]] std::uint32_t width() const noexcept { return grid_.width; }
  [[nodiscard]] std::uint32_t height() const noexcept { return grid_.height; }
  [[nodiscard]] std::span<const float> samples() const noexcept { return samples_; }
  [[nodiscard]] double mean() const noexcept { return mean_; }  ///< Of the samples, and so of the function.
  [[nodiscard]] const SplineBounds& bounds() const noexcept { return bounds_; }

 private:
  std::vector<float> samples_;
  SplineGrid grid_;
  SplineBounds bounds_;
  double perWidth_, perHeight_;
  double mean_;

  SampledField(std::vector<float> samples, SplineGrid grid);
};

}  // namespace haptics

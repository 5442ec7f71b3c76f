#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/error/error.h"
#include "common/maths/vec.h"
#include "common/surface/near_samples.h"
#include "common/surface/scalar_field.h"

namespace haptics {

/// A dimensionless function given at points that are scattered over a surface, as Turk (1991) has it: between them the
/// average of the samples within reach, weighted by w = (1 - (d / reach)^2)^3 at a distance of d, which is C2,
///   f(x) = g(W) * (sum of w_i v_i) / W,  W = sum of w_i.
/// g lets it fade to 0 away from all samples: it rises from 0 to 1 (C2) as W goes from 0 to kWholeWeight, so that the
/// average is whole wherever a sample is nearer than 0.45 of the reach, and 0 from the reach on.
///
/// Distances are straight: where two sides of a surface lie within reach of each other, each has part of the other's
/// values. Immutable: at() from any thread.
class PointField {
 public:
  static constexpr std::size_t kMaxSamples = 60'000;
  static constexpr float kMaxCoordinate_m = 1e3F;
  static constexpr float kMinReach_m = 1e-6F, kMaxReach_m = 1e3F;
  static constexpr double kWholeWeight = 0.5;

  /// \param reach_m the farthest that a sample has a part in values: twice the distance between neighbours or a little
  ///        more keeps the function from rippling.
  /// \param samples 1 to kMaxSamples. Refused, naming "reach_m", "count", "samples" or "samples[7].point": numbers that
  ///        are not finite, -0 or beyond kMaxCoordinate_m and kMaxFieldValue, a reach out of range, and what
  ///        NearSamples refuses.
  [[nodiscard]] static Result<PointField> make(float reach_m, std::vector<PointSample> samples);

  /// Costs by the samples near the point, of which there are at most NearSamples::kMaxNear. No allocation.
  /// \param point object frame, m; finite.
  [[nodiscard]] FieldSample at(Vec3 point) const noexcept;

  [[nodiscard]] float reach_m() const noexcept { return reach_m_; }
  [[nodiscard]] std::span<const PointSample> samples() const noexcept { return samples_; }
  /// Lowest and highest by climbs from the most extreme samples. Slope and curvature: the largest at 4096 of the samples
  /// and half way from each to its nearest one, with a tenth more; farther from the surface they may be larger.
  [[nodiscard]] const FieldBounds& bounds() const noexcept { return bounds_; }

 private:
  float reach_m_;
  double perSquaredReach_;
  std::vector<PointSample> samples_;
  NearSamples near_;
  FieldBounds bounds_;

  PointField(float reach_m, std::vector<PointSample> samples, NearSamples near);
};

}  // namespace haptics

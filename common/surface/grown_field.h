#pragma once

#include <memory>

#include "common/surface/point_field.h"
#include "common/surface/scalar_field.h"

namespace haptics {

/// A pattern that was grown on a mesh (Turk 1991), or any other that is given by samples on it. Shortest wavelength: that
/// of which the weights leave half, 1.75 times the reach. Over a plane they leave 384 J_4(x) / x^4 of a wave, with
/// x = 2 pi reach / wavelength: half of it at x = 3.6.
class GrownField final : public ScalarField {
 public:
  explicit GrownField(std::shared_ptr<const PointField> points)
      : ScalarField(points->bounds(), kShortestWave * points->reach_m()), points_(std::move(points)) {}

  [[nodiscard]] FieldSample at(Vec3 point) const noexcept override { return points_->at(point); }

 private:
  static constexpr double kShortestWave = 1.75;  ///< Of the reach.
  std::shared_ptr<const PointField> points_;
};

}  // namespace haptics

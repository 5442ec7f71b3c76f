#pragma once

#include <cmath>
#include <numbers>

#include "common/maths/elementary.h"
#include "common/maths/vec.h"

namespace haptics {

/// How a dent fades with the distance from its centre: (1 - (distance / radius)^2)^degree, 1 at the centre and nothing
/// from the radius on. From degree 2 on it is C1 at the rim, and flat at the centre whatever the degree. A polynomial, as
/// in section 5 (d) of the paper; the same operations in both processes, so that both see bit-identical shapes.
class Falloff {
 public:
  static constexpr unsigned kMinDegree = 2;
  static constexpr unsigned kMaxDegree = 8;

  /// @param radius_m  > 0.
  /// @param degree  kMinDegree to kMaxDegree. Larger is narrower.
  Falloff(double radius_m, unsigned degree) noexcept
      : radius_(radius_m), inverse2_(1 / (radius_m * radius_m)), degree_(degree) {
    const double n = degree;
    const double at = 1 / std::sqrt(2 * n - 1);
    double power = 1;
    for (unsigned i = 1; i < degree; ++i) power *= 1 - at * at;
    steepest_ = 2 * n * at * power / radius_m;
  }

  [[nodiscard]] double radius_m() const noexcept { return radius_; }
  [[nodiscard]] unsigned degree() const noexcept { return degree_; }

  [[nodiscard]] double at(Vec3 fromCentre) const noexcept {
    const double inside = 1 - squaredLength(fromCentre) * inverse2_;
    if (!(inside > 0)) return 0;
    double power = inside;
    for (unsigned i = 1; i < degree_; ++i) power *= inside;
    return power;
  }

  struct Slope {
    double value = 0;  ///< at().
    Vec3 gradient{0};  ///< Of it, per metre.
  };
  [[nodiscard]] Slope slopeAt(Vec3 fromCentre) const noexcept {
    const double inside = 1 - squaredLength(fromCentre) * inverse2_;
    if (!(inside > 0)) return {};
    double power = 1;
    for (unsigned i = 1; i < degree_; ++i) power *= inside;
    return {power * inside, fromCentre * (-2 * inverse2_ * degree_ * power)};
  }

  /// Distance at which two dents beside each other are half as deep as at their centres: what they make together is about
  /// as deep all the way between them.
  [[nodiscard]] double width_m() const noexcept {
    return 2 * radius_ * std::sqrt(1 - elementary::exp(-std::numbers::ln2 / degree_));
  }

  /// Steepest slope of the falloff, per metre, at distance radius / sqrt(2 degree - 1).
  [[nodiscard]] double maxSlope_per_m() const noexcept { return steepest_; }

  bool operator==(const Falloff&) const = default;

 private:
  double radius_;
  double inverse2_;
  double steepest_;
  unsigned degree_;
};

}  // namespace haptics

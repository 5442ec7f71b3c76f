#pragma once

#include <algorithm>
#include <cmath>

#include "haptic_server/engine/collision/polytope_contact.h"

namespace haptics {

/// Of the axes along which two polytopes are level, the best one among them, the one to which they come least fast: a body goes
/// over the side of a flush neighbour.
class LevelAxis {
 public:
  /// @param nearest  The place that is nearest along the axis; second's frame.
  LevelAxis(const PolytopeWay& way, Vec3 best, double gap_m, Vec3 nearest) noexcept
      : way_(way), best_(best), slowest_(best), gap_m_(gap_m), closing_m_per_s_(closingAlong(best, nearest)) {}

  /// m/s. Of what parts there is nothing to stop, and no overlap to push apart.
  [[nodiscard]] double closingAlong(Vec3 normal, Vec3 nearest) const noexcept {
    return std::max(-glm::dot(normal, way_.linear + glm::cross(way_.angular, nearest)), 0.0);
  }
  /// Else takes() need not be asked.
  [[nodiscard]] bool mayTake(Vec3 normal) const noexcept {
    return glm::dot(normal, best_) <= (closing_m_per_s_ > kLessFast_m_per_s ? kSame : kAlike) &&
           !way_.isTurnedOver(normal);
  }
  /// Where it may: whether it is so far that axis.
  [[nodiscard]] bool takes(Vec3 normal, double gap_m, Vec3 nearest) noexcept {
    if (gap_m < -way_.step_m) return false;
    isOneOfTwo_ = isOneOfTwo_ || glm::dot(normal, best_) < kAlike;
    const double faster_m_per_s = closingAlong(normal, nearest) - closing_m_per_s_;
    if (std::abs(faster_m_per_s) <= kLessFast_m_per_s) {
      isTied_ =
          isTied_ || (gap_m <= kTouching_m && gap_m_ <= kTouching_m && std::abs(glm::dot(normal, slowest_)) < kAlike);
      return false;
    }
    if (faster_m_per_s > 0) return false;
    slowest_ = normal;
    gap_m_ = gap_m;
    closing_m_per_s_ += faster_m_per_s;
    isTied_ = false;
    return true;
  }
  /// Two such axes are as slow, and the bodies touch along both: they share a line, and neither is to stop them. One that
  /// stands exactly beside a tile could not start.
  [[nodiscard]] bool isTied() const noexcept { return isTied_; }
  /// There is another one: which of them it is may be otherwise in the next tick.
  [[nodiscard]] bool isOneOfTwo() const noexcept { return isOneOfTwo_; }

 private:
  /// Cosines above which axes are one, and of one side.
  static constexpr double kSame = 0.9999, kAlike = 0.9;
  static constexpr double kLessFast_m_per_s = 1e-5;
  static constexpr double kTouching_m = 1e-6;  ///< More than rounding of float32 makes of flush bodies of some metres.

  const PolytopeWay& way_;
  Vec3 best_, slowest_;
  double gap_m_, closing_m_per_s_;
  bool isTied_ = false, isOneOfTwo_ = false;
};

}  // namespace haptics

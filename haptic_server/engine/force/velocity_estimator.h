#pragma once

#include <cstdint>
#include <numbers>

#include "common/maths/elementary.h"
#include "common/maths/vec.h"

namespace haptics {

/// The one velocity estimate of the servo: a critically damped g-h (fading-memory) filter on the measured position
/// (Brookner 1998, section 1.3). A raw difference will not do: one 55 um encoder step in 1 ms is 55 mm/s.
class VelocityEstimator {
 public:
  /// Double pole, hertz. Higher follows sooner and lets more quantisation through: at 100 Hz and 1 kHz one encoder step
  /// of 55 um shows as 12 mm/s and a ramp is followed 2.3 ms late.
  static constexpr double kBandwidth_Hz = 100;

  explicit VelocityEstimator(double period_s = 1e-3) noexcept : period_(period_s) {
    const double theta = elementary::exp(-2 * std::numbers::pi * kBandwidth_Hz * period_s);
    positionGain_ = 1 - theta * theta;
    velocityGain_ = (1 - theta) * (1 - theta) / period_s;
  }

  /// At rest at this position (m).
  void reset(Vec3 position) noexcept {
    position_ = position;
    velocity_ = Vec3(0);
  }

  /// Takes the position measured this tick (m), returns the velocity (m/s).
  Vec3 update(Vec3 measured) noexcept {
    const Vec3 predicted = position_ + velocity_ * period_;
    const Vec3 error = measured - predicted;
    position_ = predicted + error * positionGain_;
    velocity_ += error * velocityGain_;
    return velocity_;
  }

  /// Ticks that never came: the device went on.
  void skip(std::uint64_t ticks) noexcept { position_ += static_cast<double>(ticks) * period_ * velocity_; }

  /// Takes over what another estimator found.
  void set(Vec3 position, Vec3 velocity) noexcept {
    position_ = position;
    velocity_ = velocity;
  }

  [[nodiscard]] Vec3 velocity() const noexcept { return velocity_; }

  HAPTICS_FIELDS(self.period_, self.positionGain_, self.velocityGain_, self.position_, self.velocity_);

 private:
  double period_;
  double positionGain_;
  double velocityGain_;  // 1/s
  Vec3 position_{0};
  Vec3 velocity_{0};
};

}  // namespace haptics

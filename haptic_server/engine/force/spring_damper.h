#pragma once

#include <algorithm>

#include "common/maths/vec.h"

namespace haptics {

/// What a surface feels like along its normal.
struct Stiffness {
  double spring_N_per_m = 0;
  double damping_Ns_per_m = 0;

  bool operator==(const Stiffness&) const = default;
  HAPTICS_FIELDS(self.spring_N_per_m, self.damping_Ns_per_m);
};

/// The larger of each.
[[nodiscard]] inline Stiffness stiffer(Stiffness a, Stiffness b) noexcept {
  return {std::max(a.spring_N_per_m, b.spring_N_per_m), std::max(a.damping_Ns_per_m, b.damping_Ns_per_m)};
}

/// Newtons along a direction out of the surface, on the hand.
struct SpringDamper {
  double spring = 0;
  double damping = 0;
};

/// Hooke's law on the penetration vector (paper 3, F = kx) with a damper along it.
///
/// @param penetration_m  Length of the penetration vector IHIP - HIP.
/// @param approach_m_per_s  Velocity of the HIP relative to the surface along the direction; negative when pressing in.
/// Deviation from the paper, which has no damper: the damper may take the spring's force away but never pulls the hand
/// towards the surface.
[[nodiscard]] inline SpringDamper springDamper(double penetration_m, double approach_m_per_s, Stiffness k) noexcept {
  const double spring = k.spring_N_per_m * penetration_m;
  return {spring, std::max(-k.damping_Ns_per_m * approach_m_per_s, -spring)};
}

/// Newtons, world frame, on the hand.
struct SpringDamperForce {
  Vec3 spring{0};
  Vec3 damping{0};
};

/// The same as vectors.
/// @param direction  Unit vector out of the surface: along the penetration vector, or the surface's normal at depth 0.
[[nodiscard]] inline SpringDamperForce springDamper(double penetration_m, Vec3 direction, double approach_m_per_s,
                                                    Stiffness k) noexcept {
  const SpringDamper along = springDamper(penetration_m, approach_m_per_s, k);
  return {along.spring * direction, along.damping * direction};
}

/// Bounds how fast an edit of the material (or the coming or going of an object under the stylus) is felt.
///
/// The felt stiffness moves towards the object's by as much as changes the force by kRate_N_per_s; with no contact it is there
/// at once. So the contact force itself has no step, before any limit. Where the object's stiffness varies over its surface,
/// that is so of the stiffness at a factor of 1, and what is felt is as much as the factor at the IHIP makes of it.
class RateLimitedStiffness {
 public:
  /// Newtons per second. Higher makes an edit felt sooner and as more of a kick: 30 N/s is 0.03 N a tick at 1 kHz, and
  /// 2 N fade in 67 ms.
  static constexpr double kRate_N_per_s = 30;

  [[nodiscard]] Stiffness value() const noexcept { return felt_; }
  /// At a factor of 1.
  [[nodiscard]] Stiffness mean() const noexcept { return mean_; }

  /// To a part of itself, 0 to 1.
  void fade(double part) noexcept {
    felt_ = times(felt_, part);
    mean_ = times(mean_, part);
  }

  /// Goes to another place of the surface.
  void vary(double factor) noexcept {
    factor_ = factor;
    felt_ = times(mean_, factor);
  }
  /// The factor at the place is another one from here on, by an edit: what is felt is as it was.
  /// @param factor  More than 0.
  void varyByEdit(double factor) noexcept {
    factor_ = factor;
    mean_ = times(felt_, 1 / factor);
  }

  /// @param target  At a factor of 1.
  /// @param penetration_m, approach_m_per_s  As in springDamper(); 0 when the object is not in contact.
  /// @param maxForce_N  The device's: what the spring has beyond it is not felt, and goes or comes at once.
  /// @return Joules that the change put into the pressed spring.
  double follow(Stiffness target, double penetration_m, double approach_m_per_s, double maxForce_N,
                double period_s) noexcept {
    if (mean_ == target) return 0;
    const double before_N_per_m = felt_.spring_N_per_m;
    approach(target, penetration_m, approach_m_per_s, maxForce_N, period_s);
    felt_ = times(mean_, factor_);
    const double put_J = (felt_.spring_N_per_m - before_N_per_m) / 2 * penetration_m * penetration_m;
    return std::isfinite(put_J) ? put_J : 0;
  }

  HAPTICS_FIELDS(self.felt_, self.mean_, self.factor_);

 private:
  void approach(Stiffness target, double penetration_m, double approach_m_per_s, double maxForce_N,
                double period_s) noexcept {
    const Stiffness missing{target.spring_N_per_m - mean_.spring_N_per_m,
                            target.damping_Ns_per_m - mean_.damping_Ns_per_m};
    const double change = factor_ * (std::abs(missing.spring_N_per_m * penetration_m) +
                                     std::abs(missing.damping_Ns_per_m * approach_m_per_s));
    const double beyond_N = std::max(0.0, felt_.spring_N_per_m * penetration_m - maxForce_N);
    const double allowed = kRate_N_per_s * period_s + beyond_N;
    if (!(change > allowed)) {  // or it is no number, which would stay
      mean_ = target;
      return;
    }
    const double part = allowed / change;
    mean_.spring_N_per_m += part * missing.spring_N_per_m;
    mean_.damping_Ns_per_m += part * missing.damping_Ns_per_m;
  }

  [[nodiscard]] static Stiffness times(Stiffness k, double factor) noexcept {
    return {k.spring_N_per_m * factor, k.damping_Ns_per_m * factor};
  }

  Stiffness felt_;  // nothing at first: an object that appears around the stylus fades in
  Stiffness mean_;
  double factor_ = 1;
};

}  // namespace haptics

#pragma once

#include <optional>

#include "common/maths/rotation.h"
#include "haptic_server/engine/force/output_chain.h"
#include "haptic_server/engine/force/predictive_observer.h"
#include "haptic_server/engine/force/spring_damper.h"

namespace haptics {

/// What the step knows of how a device turns.
struct RotationConfig {
  /// On which it turns as its mass moves (gyration_m()): rotations are estimated and limited as translations on it.
  double radius_m = 0.05;
  double maxTorque_Nm = 0;  ///< Magnitude limit; 0: the device gives no torque.
  /// Of the translation on the radius; none: rotations are felt as measured.
  std::optional<ObserverSettings> observer = std::nullopt;

  bool operator==(const RotationConfig&) const = default;
};

/// How a device is turned, and the torque on the hand: what observer, limits of edits and magnitude do to positions and
/// forces, on the way that a sphere of the radius r would roll,
///   x = r (sum of the rotations measured, as vectors),   F = T / r,   K = K_r / r^2.
/// World frame; noexcept, no allocation. The moment on a gripper is one about the first axis.
class DeviceTorque {
 public:
  DeviceTorque() noexcept = default;
  DeviceTorque(const RotationConfig& config, double period_s) noexcept
      : period_s_(period_s), radius_m_(config.radius_m), maxTorque_Nm_(config.maxTorque_Nm) {
    if (config.observer) observer_ = PredictiveObserver(*config.observer, period_s);
  }

  /// At rest there, with nothing felt. What was felt before goes as by an edit.
  void reset(Quat measured) noexcept {
    measured_ = measured;
    rolled_m_ = predicted_m_ = felt_Nm_ = Vec3(0);
    if (observer_.active()) observer_.reset(rolled_m_);
    slew_ = {};
    torsion_ = {};
  }

  /// Takes the rotation measured this tick, returns the one for which the torque is to be computed.
  [[nodiscard]] Quat follow(Quat measured) noexcept {
    rolled_m_ += radius_m_ * rotationVector(measured * glm::conjugate(measured_));
    measured_ = measured;
    predicted_m_ = observer_.active() ? observer_.follow(rolled_m_) : rolled_m_;
    return glm::normalize(rotationBy((predicted_m_ - rolled_m_) / radius_m_) * measured);
  }

  /// The torque of a spring of this torsion that is turned by `twist_rad`; an edit of the torsion comes without a step.
  void setTwist(Vec3 twist_rad, double torsion_Nm_per_rad) noexcept {
    const double stretch_m = radius_m_ * glm::length(twist_rad);
    (void)torsion_.follow({torsion_Nm_per_rad / (radius_m_ * radius_m_), 0}, stretch_m, 0, maxTorque_Nm_ / radius_m_,
                          period_s_);
    felt_Nm_ = torsion_.value().spring_N_per_m * radius_m_ * radius_m_ * twist_rad;
  }

  /// There is no spring any more.
  void release() noexcept { felt_Nm_ = Vec3(0); }

  /// Slew limit of an edit, magnitude limit, fault ramp: as forces have them.
  /// Once a tick. written_Nm() is for the device then.
  /// @param gain  The ramp's.
  /// @param jumps  An edit, or a tick that spent its allowance, changes it at once.
  /// @param isHeld  Something holds the tool: else its torque is what it lags behind in free space.
  void limit(double gain, bool isFaulty, bool jumps, bool isHeld) noexcept {
    if (!isFaulty)
      unlimited_Nm_ = slewed(isFinite(felt_Nm_) ? limitMagnitude(felt_Nm_, maxTorque_Nm_) : Vec3(0), jumps);
    written_Nm_ = gain * unlimited_Nm_;
    if (!observer_.active()) return;
    const double length = glm::length(felt_Nm_);
    observer_.onForceWritten(onRadius(written_Nm_), isHeld && length > 0 ? felt_Nm_ / length : Vec3(0),
                             torsion_.value().spring_N_per_m);
  }

  /// Ticks that never came.
  void skip(std::uint64_t ticks) noexcept {
    if (observer_.active()) observer_.skip(ticks);
  }

  [[nodiscard]] Quat measured() const noexcept { return measured_; }
  [[nodiscard]] Vec3 felt_Nm() const noexcept { return felt_Nm_; }        ///< Of the spring.
  [[nodiscard]] Vec3 written_Nm() const noexcept { return written_Nm_; }  ///< For the device: zero where it gives none.

  /// As PredictiveObserver::couldBecome().
  [[nodiscard]] bool couldBecome(const DeviceTorque& later) const noexcept {
    return observer_.couldBecome(later.observer_) && isRotation(later.measured_);
  }

  HAPTICS_FIELDS(self.period_s_, self.radius_m_, self.maxTorque_Nm_, self.measured_, self.rolled_m_, self.predicted_m_,
                 self.felt_Nm_, self.unlimited_Nm_, self.written_Nm_, self.torsion_, self.slew_, self.observer_);

 private:
  [[nodiscard]] Vec3 onRadius(Vec3 torque_Nm) const noexcept { return torque_Nm / radius_m_; }

  [[nodiscard]] Vec3 slewed(Vec3 torque_Nm, bool jumps) noexcept {
    if (jumps) slew_.begin();
    if (!slew_.active()) return torque_Nm;
    return limitMagnitude(radius_m_ * slew_.follow(onRadius(unlimited_Nm_), onRadius(torque_Nm), rolled_m_,
                                                   predicted_m_, 0, torsion_.value(), jumps, period_s_),
                          maxTorque_Nm_);
  }

  double period_s_ = 1e-3, radius_m_ = RotationConfig{}.radius_m, maxTorque_Nm_ = 0;
  Quat measured_{1, 0, 0, 0};
  Vec3 rolled_m_{0}, predicted_m_{0};  // where the sphere has rolled to, and will be
  Vec3 felt_Nm_{0}, unlimited_Nm_{0}, written_Nm_{0};
  RateLimitedStiffness torsion_;
  EditSlew slew_;
  PredictiveObserver observer_;
};

}  // namespace haptics

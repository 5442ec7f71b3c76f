#pragma once

#include "haptic_server/device/device.h"
#include "haptic_server/device/plant.h"

namespace haptics {

/// How a simulated device turns in the hand that holds it:
///   I w' + b w + t_c w/|w| = T_hand + T_motor,   T_hand = k_r angle(q_t, q) + b_r (w_t - w),
/// alike about all axes, without gyroscopic torque, which such a body has none of. It is the plant of a translation
/// (rotationAsTranslation()), rolled off on the sphere of its radius; the hand is that preset's on a lever of
/// kUsualGyration_m. SI units, world frame. Deterministic, noexcept, no allocation.
class SimulatedRotation {
 public:
  SimulatedRotation(const DeviceInfo& device, const HandPreset& hand);

  /// At rest.
  void place(Quat rotation) noexcept;
  /// As Plant::step(). `targetSpeed` in rad/s.
  void step(double h_s, Vec3 motor_Nm, Quat target, Vec3 targetSpeed) noexcept;

  [[nodiscard]] Quat rotation() const noexcept { return rotation_; }
  [[nodiscard]] Vec3 velocity() const noexcept { return plant_.velocity() / radius_; }  ///< rad/s.

 private:
  double radius_;
  Plant plant_;
  Quat rotation_{1, 0, 0, 0};
};

}  // namespace haptics

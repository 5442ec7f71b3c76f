#pragma once

#include "common/maths/vec.h"
#include "haptic_server/device/hand_intent.h"
#include "haptic_server/device/presets.h"

namespace haptics {

/// The mechanics of a simulated device and the hand that holds it, in continuous time:
///   m x'' + b x' + f_c x'/|x'| = F_hand + F_motor,   F_hand = k (x_t - x) + b_h (x_t' - x') + push,
/// m the sum of the device's and the hand's mass, three-dimensional, the same in all directions; no gravity (a device
/// and an arm carry their own weight). SI units, world frame. Deterministic, noexcept, no allocation.
class Plant {
 public:
  Plant(const DevicePreset& device, const HandPreset& hand) noexcept;

  /// At rest at a position, the hand's target with it.
  void place(Vec3 position) noexcept;

  /// One integration step of h_s seconds under a constant motor force. `target` is the hand's at the middle of the
  /// step, `targetVelocity` its velocity in m/s.
  void step(double h_s, Vec3 motor_N, const HandTarget& target, Vec3 targetVelocity) noexcept;

  [[nodiscard]] Vec3 position() const noexcept { return position_; }
  [[nodiscard]] Vec3 velocity() const noexcept { return velocity_; }
  [[nodiscard]] double mass_kg() const noexcept { return mass_; }

 private:
  double mass_;
  double viscousFriction_;
  double coulombFriction_;
  double handStiffness_;
  double handDamping_;
  Vec3 position_{0};
  Vec3 velocity_{0};
};

}  // namespace haptics

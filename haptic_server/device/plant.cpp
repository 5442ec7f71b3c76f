#include "haptic_server/device/plant.h"

#include <cmath>

namespace haptics {

Plant::Plant(const DevicePreset& device, const HandPreset& hand) noexcept
    : mass_(device.apparentMass_kg + hand.mass_kg),
      viscousFriction_(device.viscousFriction_Ns_per_m),
      coulombFriction_(device.coulombFriction_N),
      handStiffness_(hand.stiffness_N_per_m),
      handDamping_(hand.damping_Ns_per_m) {}

void Plant::place(Vec3 position) noexcept {
  position_ = position;
  velocity_ = Vec3(0);
}

// Implicit midpoint rule, solved for the mean velocity u of the step: exact for a constant force, of second order, and
// the kinetic energy changes by exactly the work of the forces, so the integrator itself neither feeds nor drains the
// stability limits that are measured with it. Friction enters as f_c u/|u|; because everything else is linear and equal
// in all directions, (2m/h + b + b_h + kh/2) u = rest - f_c u/|u| has a closed solution, which is u = 0 for
// |rest| <= f_c: sticking, without a threshold of velocity and without chatter. (The rule alone would then reflect the
// velocity; a stuck device has none.)
void Plant::step(double h_s, Vec3 motor_N, const HandTarget& target, Vec3 targetVelocity) noexcept {
  const double inertia = 2 * mass_ / h_s;
  const Vec3 rest = inertia * velocity_ + motor_N + target.push_N + handStiffness_ * (target.position - position_) +
                    handDamping_ * targetVelocity;
  const double magnitude = std::sqrt(squaredLength(rest));
  if (magnitude <= coulombFriction_) {
    velocity_ = Vec3(0);
    return;
  }
  const double resistance = inertia + viscousFriction_ + handDamping_ + handStiffness_ * h_s / 2;
  const Vec3 mean = rest * ((1 - coulombFriction_ / magnitude) / resistance);
  position_ += h_s * mean;
  velocity_ = 2.0 * mean - velocity_;
}

}  // namespace haptics

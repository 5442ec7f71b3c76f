#include "haptic_server/device/simulated_rotation.h"

#include "common/maths/rotation.h"
#include "haptic_server/device/simulated_device.h"

namespace haptics {
namespace {

[[nodiscard]] HandPreset onLever(const HandPreset& hand, double radius) noexcept {
  const double lever = kUsualGyration_m / radius;
  const double ratio = lever * lever;
  return {hand.name, ratio * hand.mass_kg, ratio * hand.stiffness_N_per_m, ratio * hand.damping_Ns_per_m};
}

}  // namespace

SimulatedRotation::SimulatedRotation(const DeviceInfo& device, const HandPreset& hand)
    : radius_(gyration_m(device)), plant_(presetOf(rotationAsTranslation(device)), onLever(hand, radius_)) {}

void SimulatedRotation::place(Quat rotation) noexcept {
  plant_.place(Vec3(0));
  rotation_ = rotation;
}

void SimulatedRotation::step(double h_s, Vec3 motor_Nm, Quat target, Vec3 targetSpeed) noexcept {
  const Vec3 before = plant_.position();
  const Vec3 way = radius_ * rotationVector(target * glm::conjugate(rotation_));
  plant_.step(h_s, motor_Nm / radius_, {before + way, Vec3(0)}, radius_ * targetSpeed);
  const Vec3 rolled = plant_.position() - before;
  if (rolled != Vec3(0)) rotation_ = glm::normalize(rotationBy(rolled / radius_) * rotation_);
}

}  // namespace haptics

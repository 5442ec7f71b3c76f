#include "haptic_server/device/simulated_device.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/maths/rotation.h"

namespace haptics {
namespace {

DeviceInfo describe(const DevicePreset& preset, double delay_s) {
  return {std::string(preset.title) + " (simulated)",
          preset.maxForce_N,
          preset.maxStiffness_N_per_m,
          preset.maxDamping_Ns_per_m,
          preset.resolution_m,
          preset.apparentMass_kg,
          preset.viscousFriction_Ns_per_m,
          preset.coulombFriction_N,
          delay_s,
          preset.rotation,
          preset.gripper};
}

Vec3 quantised(Vec3 position, double quantum) noexcept { return quantum * glm::floor(position / quantum + 0.5); }

/// Shortened to the limit; zero where it is not finite.
Vec3 bounded(Vec3 output, double limit) noexcept {
  const double magnitude = glm::length(output);
  return std::isfinite(magnitude) ? output * std::min(1.0, limit / magnitude) : Vec3(0);
}

}  // namespace

DevicePreset presetOf(const DeviceInfo& device) noexcept {
  return {"",
          "",
          device.maxForce_N,
          device.maxStiffness_N_per_m,
          device.maxDamping_Ns_per_m,
          device.apparentMass_kg,
          device.viscousFriction_Ns_per_m,
          device.coulombFriction_N,
          device.resolution_m,
          device.rotation,
          device.gripper};
}

SimulatedDevice::SimulatedDevice(const SimulationSettings& settings, HandIntent& intent)
    : info_(describe(settings.device, settings.delay_s)),
      plant_(settings.device, settings.hand),
      intent_(intent),
      period_(settings.period_s),
      substep_(settings.period_s / kSubsteps),
      delay_(static_cast<int>(std::lround(settings.delay_s / settings.period_s * kSubsteps))),
      written_(static_cast<std::size_t>(delay_ / kSubsteps) + 2, Vec3(0)),
      fingerStiffness_(settings.hand.stiffness_N_per_m * kUsualGyration_m * kUsualGyration_m),
      fingerDamping_((settings.hand.damping_Ns_per_m + settings.device.viscousFriction_Ns_per_m) * kUsualGyration_m *
                     kUsualGyration_m) {
  if (!info_.rotation.isSensed) return;
  turning_.emplace(Turning{.plant = SimulatedRotation(info_, settings.hand), .written_Nm = written_});
}

DeviceReading SimulatedDevice::read(std::uint64_t tick) noexcept {
  if (!started_) {
    started_ = true;
    target_ = intent_.next(0, felt_);
    plant_.place(target_.position);
    if (turning_) turning_->plant.place(turning_->target = intent_.nextRotation(0));
  } else if (tick > tick_) {
    const std::uint64_t ticks = std::min(tick - tick_, kMaxTicksAtOnce);
    for (std::uint64_t i = 0; i < ticks; ++i) {
      beginTick();
      for (int substep = 0; substep < kSubsteps; ++substep) integrateSubstep(substep);
      endTick();
    }
  }
  tick_ = tick;
  DeviceReading reading{quantised(plant_.position(), info_.resolution_m),
                        stopped_ ? DeviceState::kStopped : DeviceState::kReady};
  if (turning_) reading.rotation = measuredRotation();
  reading.status.buttons = intent_.buttons();
  if (info_.gripper.range_rad > 0) {
    reading.gripper_rad = reading.handle.gripper_rad = gripper_;
    reading.handle.measured = HandleReading::kGripper;
  }
  return reading;
}

void SimulatedDevice::write(Vec3 force_N) noexcept {
  if (!stopped_) held_ = bounded(force_N, info_.maxForce_N);
}

void SimulatedDevice::writeTorque(Vec3 torque_Nm) noexcept {
  if (!stopped_ && turning_) turning_->held_Nm = bounded(torque_Nm, info_.rotation.maxTorque_Nm);
}

void SimulatedDevice::writeGrip(double moment_Nm) noexcept {
  if (!stopped_) grip_Nm_ = bounded({moment_Nm, 0, 0}, info_.gripper.maxMoment_Nm).x;
}

void SimulatedDevice::stop() noexcept {
  held_ = Vec3(0);
  grip_Nm_ = 0;
  if (turning_) turning_->held_Nm = Vec3(0);
  stopped_ = true;
}

void SimulatedDevice::advanceTogether(std::span<SimulatedDevice* const> devices, std::uint64_t tick) noexcept {
  const auto isBehind = [tick](const SimulatedDevice* device) { return device->started_ && device->tick_ < tick; };
  for (SimulatedDevice* device : devices) {
    if (isBehind(device)) device->beginTick();
  }
  for (int i = 0; i < kSubsteps; ++i) {
    for (SimulatedDevice* device : devices) {
      if (isBehind(device)) device->integrateSubstep(i);
    }
  }
  for (SimulatedDevice* device : devices) {
    if (!isBehind(device)) continue;
    device->endTick();
    ++device->tick_;
  }
}

void SimulatedDevice::beginTick() noexcept {
  newest_ = (newest_ + 1) % written_.size();
  written_[newest_] = held_;
  from_ = target_;
  target_ = intent_.next(period_, felt_);
  targetVelocity_ = (target_.position - from_.position) / period_;
  if (turning_) beginTurning();
  if (info_.gripper.range_rad > 0) moveGripper();
}

/// By how much the fingers give way: b dy/dt = M - k y.
void SimulatedDevice::moveGripper() noexcept {
  double yields_rad = gripper_ - wantedGripper_;
  if (fingerDamping_ > 0) yields_rad += period_ * (grip_Nm_ - fingerStiffness_ * yields_rad) / fingerDamping_;
  const double range_rad = info_.gripper.range_rad;
  wantedGripper_ = std::clamp(intent_.nextGripper_rad(period_, wantedGripper_), 0.0, range_rad);
  gripper_ = std::clamp(wantedGripper_ + yields_rad, 0.0, range_rad);
}

void SimulatedDevice::integrateSubstep(int substep) noexcept {
  const double middle = (substep + 0.5) / kSubsteps;
  const HandTarget now{glm::mix(from_.position, target_.position, middle), target_.push_N};
  plant_.step(substep_, motorForce(substep), now, targetVelocity_);
  if (turning_) turn(substep);
}

// F_ZOH(t - t_d): the force of the tick that t - t_d lies in.
std::size_t SimulatedDevice::heldIn(int substep) const noexcept {
  const int ticksAgo = (delay_ - substep + kSubsteps - 1) / kSubsteps;
  const std::size_t ago = static_cast<std::size_t>(std::max(ticksAgo, 0));
  return newest_ >= ago ? newest_ - ago : newest_ + written_.size() - ago;
}

void SimulatedDevice::beginTurning() noexcept {
  Turning& turning = *turning_;
  turning.written_Nm[newest_] = turning.held_Nm;
  turning.from = turning.target;
  turning.target = intent_.nextRotation(period_);
  turning.targetSpeed = rotationVector(turning.target * glm::conjugate(turning.from)) / period_;
}

void SimulatedDevice::turn(int substep) noexcept {
  Turning& turning = *turning_;
  const double middle = (substep + 0.5) / kSubsteps;
  const Quat now = rotationBy(middle * period_ * turning.targetSpeed) * turning.from;
  turning.plant.step(substep_, turning.written_Nm[heldIn(substep)], now, turning.targetSpeed);
}

/// Encoders count angles from where it is upright.
Quat SimulatedDevice::measuredRotation() const noexcept {
  return rotationBy(quantised(rotationVector(turning_->plant.rotation()), info_.rotation.resolution_rad));
}

}  // namespace haptics

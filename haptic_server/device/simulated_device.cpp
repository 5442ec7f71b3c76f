#include "haptic_server/device/simulated_device.h"

#include <algorithm>
#include <cmath>
#include <string>

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
          delay_s};
}

Vec3 quantised(Vec3 position, double quantum) noexcept { return quantum * glm::floor(position / quantum + 0.5); }

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
          device.resolution_m};
}

SimulatedDevice::SimulatedDevice(const SimulationSettings& settings, HandIntent& intent)
    : info_(describe(settings.device, settings.delay_s)),
      plant_(settings.device, settings.hand),
      intent_(intent),
      period_(settings.period_s),
      substep_(settings.period_s / kSubsteps),
      delay_(static_cast<int>(std::lround(settings.delay_s / settings.period_s * kSubsteps))),
      written_(static_cast<std::size_t>(delay_ / kSubsteps) + 2, Vec3(0)) {}

DeviceReading SimulatedDevice::read(std::uint64_t tick) noexcept {
  if (!started_) {
    started_ = true;
    target_ = intent_.next(0, felt_);
    plant_.place(target_.position);
  } else if (tick > tick_) {
    const std::uint64_t ticks = std::min(tick - tick_, kMaxTicksAtOnce);
    for (std::uint64_t i = 0; i < ticks; ++i) {
      beginTick();
      for (int substep = 0; substep < kSubsteps; ++substep) integrateSubstep(substep);
      endTick();
    }
  }
  tick_ = tick;
  return {quantised(plant_.position(), info_.resolution_m), stopped_ ? DeviceState::kStopped : DeviceState::kReady};
}

void SimulatedDevice::write(Vec3 force_N) noexcept {
  if (stopped_) return;
  const double magnitude = glm::length(force_N);
  held_ = std::isfinite(magnitude) ? force_N * std::min(1.0, info_.maxForce_N / magnitude) : Vec3(0);
}

void SimulatedDevice::stop() noexcept {
  held_ = Vec3(0);
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
}

void SimulatedDevice::integrateSubstep(int substep) noexcept {
  const double middle = (substep + 0.5) / kSubsteps;
  const HandTarget now{glm::mix(from_.position, target_.position, middle), target_.push_N};
  plant_.step(substep_, motorForce(substep), now, targetVelocity_);
}

// F_ZOH(t - t_d): the force of the tick that t - t_d lies in.
Vec3 SimulatedDevice::motorForce(int substep) const noexcept {
  const int ticksAgo = (delay_ - substep + kSubsteps - 1) / kSubsteps;
  const std::size_t ago = static_cast<std::size_t>(std::max(ticksAgo, 0));
  return written_[newest_ >= ago ? newest_ - ago : newest_ + written_.size() - ago];
}

}  // namespace haptics

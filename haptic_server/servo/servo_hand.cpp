#include "haptic_server/servo/servo_hand.h"

#include <memory>
#include <utility>

#include "haptic_server/engine/step/moving_bodies.h"
#include "haptic_server/engine/step/soft_bodies.h"
#include "haptic_server/engine/step/tool_step.h"

namespace haptics {
namespace {

constexpr std::uint64_t kEnergyEvery_ns = 20'000'000;

}  // namespace

ServoHand::ServoHand(Device& device, const StepConfig& config, bool withCacheWarmer)
    : device_(device), config_(config), state_(config_) {
  if (withCacheWarmer) cacheWarmer_.emplace(config_);
}

void ServoHand::resumeFrom(const HapticState& state, const ServoScene* scene, const ServoScene* pending) noexcept {
  state_ = state;
  scene_ = scene != nullptr ? scene : &empty_;
  next_ = pending;
}

bool ServoHand::adopt(const ServoScene* newest, std::uint64_t tick) noexcept {
  if (newest != nullptr) next_ = newest;
  if (next_ == nullptr || !adoptScene(*next_, state_, tick)) return false;
  scene_ = std::exchange(next_, nullptr);
  device_.follow(scene_->plan.get());
  return true;
}

void ServoHand::computeForce(std::uint64_t tick, std::uint64_t now_ns) noexcept {
  std::construct_at(&result_);
  const DeviceReading reading = device_.read(tick);
  input_ = {tick, now_ns, reading};
  handle_ = reading.handle;
  const bool added = added_.acts;
  if (reading.added.acts || added) added_ = reading.added;
  if (added_.acts) result_.add(added_.force_N);
  haptics::computeForce(*scene_, state_, config_, input_, result_, cacheWarmer_ ? &cacheWarmer_->cache() : nullptr);
  if (state_.features.extras || added_.acts || added) [[unlikely]]
    writeTorque();
  device_.write(result_.force.written);
  if (cacheWarmer_) cacheWarmer_->note(result_.contact.work.allowance);
}

void ServoHand::writeTorque() noexcept {
  device_.writeTorque(writtenTorque_Nm(state_, config_, added_));
  device_.writeGrip(writtenGrip_Nm(state_));
}

RecordedTick ServoHand::recorded(std::uint64_t newScene, const TelemetrySample& sample) const noexcept {
  return {input_,  newScene, sample.force.written,  sample.fault, writtenTorque_Nm(state_, config_, added_),
          handle_, added_,   writtenGrip_Nm(state_)};
}

void ServoHand::publish(const TelemetrySample& sample) noexcept {
  account(sample);
  if (!samples_.push(sample)) increment(statistics_.droppedSamples, 1);
  if (state_.features.tool + state_.driven.count + state_.moving.count + motion_.bodyCount + state_.dents.count +
          motion_.dentCount >
      0) [[unlikely]]
    publishMotion(sample.tick);
  if (state_.reshaped.count + shapes_.count > 0) [[unlikely]] {
    if (updateShapePlaces(*scene_, state_, shapes_)) shapesOut_.put(shapes_);
  }
  if (sample.time_ns - energyPublished_ns_ >= kEnergyEvery_ns) [[unlikely]] {
    energyPublished_ns_ = sample.time_ns;
    state_.energy.copyTo(energy_);
    energyOut_.put(energy_);
  }
}

void ServoHand::publishMotion(std::uint64_t tick) noexcept {
  const bool moved = updateMotionState(state_, tick, motion_);
  const auto staying = motion_.staying;
  const std::uint64_t revision = motion_.sceneRevision;
  if (updateDentsState(state_, tick, motion_) || moved) motionOut_.put(motion_);
  if (moved || staying != motion_.staying || revision != motion_.sceneRevision) motionToBuilder_.put(motion_);
}

void ServoHand::account(const TelemetrySample& sample) noexcept {
  if (sample.object != 0) increment(statistics_.contactTicks, 1);
  if (const double force = glm::length(sample.force.written);
      force > statistics_.maxForce_N.load(std::memory_order_relaxed)) {
    statistics_.maxForce_N.store(force, std::memory_order_relaxed);
  }
  if (sample.fault != statistics_.fault.load(std::memory_order_relaxed)) {
    if (sample.fault != Fault::kNone) increment(statistics_.faults, 1);
    statistics_.fault.store(sample.fault, std::memory_order_relaxed);
    statistics_.deviceFault.store(sample.device.fault, std::memory_order_relaxed);
  }
  statistics_.wait_s.store(sample.wait_s, std::memory_order_relaxed);
  if (sample.depenetrated != statistics_.depenetrated.load(std::memory_order_relaxed)) {
    statistics_.depenetrated.store(sample.depenetrated, std::memory_order_relaxed);
    statistics_.depenetratedFrom.store(sample.depenetratedFrom, std::memory_order_relaxed);
  }
  if (sample.allowanceSpent != statistics_.allowanceSpent.load(std::memory_order_relaxed)) {
    statistics_.allowanceSpent.store(sample.allowanceSpent, std::memory_order_relaxed);
  }
}

}  // namespace haptics

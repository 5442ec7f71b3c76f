#include "haptic_server/servo/servo_loop.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <ctime>
#include <utility>

#include "common/clock/monotonic.h"
#include "haptic_server/servo/allocation_tripwire.h"
#include "haptic_server/step/moving_bodies.h"
#include "haptic_server/step/soft_bodies.h"
#include "haptic_server/step/tool_step.h"

namespace haptics {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;
constexpr std::uint64_t kEnergyEvery_ns = kSecond_ns / 50;
/// Longest pause that a replay repeats.
constexpr std::uint64_t kLongestPause_ns = kSecond_ns;

void sleepUntil(std::uint64_t deadline_ns) noexcept {
  const timespec deadline{static_cast<time_t>(deadline_ns / kSecond_ns), static_cast<long>(deadline_ns % kSecond_ns)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) == EINTR) {
  }
}

void add(std::atomic<std::uint64_t>& counter, std::uint64_t n) noexcept {  // the servo is the only writer
  counter.store(counter.load(std::memory_order_relaxed) + n, std::memory_order_relaxed);
}

}  // namespace

ServoLoop::ServoLoop(Device& device, SceneMailbox& mailbox, const StepConfig& config, bool withCacheWarmer)
    : device_(device),
      mailbox_(mailbox),
      config_(config),
      period_ns_(static_cast<std::uint64_t>(std::llround(static_cast<double>(kSecond_ns) * config.period_s))),
      state_(config_) {
  if (withCacheWarmer) cacheWarmer_.emplace(config_);
}

void ServoLoop::run(const std::atomic<bool>& stop, std::uint64_t maxTicks) noexcept {
  const std::uint64_t start_ns = monotonicNow_ns() + period_ns_;
  secondBegan_ns_ = start_ns;
  for (std::uint64_t index = 0; (maxTicks == 0 || index < maxTicks) && !stop.load(std::memory_order_relaxed); ++index) {
    sleepUntil(start_ns + index * period_ns_);
    std::uint64_t now_ns = monotonicNow_ns();
    if (const std::uint64_t current = (now_ns - start_ns) / period_ns_; current > index) {
      add(statistics_.missedTicks, current - index);
      index = current;
    }
    const std::uint64_t due_ns = start_ns + index * period_ns_;
    statistics_.wakeLatency_ns.record(now_ns - due_ns);
    now_ns = waitForSample(due_ns, now_ns);
    tick(index, now_ns, mailbox_.newest());
  }
  device_.stop();
}

void ServoLoop::resumeFrom(const HapticState& state, const ServoScene* scene, const ServoScene* pending) noexcept {
  state_ = state;
  scene_ = scene != nullptr ? scene : &empty_;
  next_ = pending;
}

void ServoLoop::run(ReplaySource& script, const std::atomic<bool>& stop) noexcept {
  const std::uint64_t longestPause = kLongestPause_ns / period_ns_;  // ticks
  std::uint64_t due_ns = monotonicNow_ns();
  secondBegan_ns_ = due_ns;
  std::uint64_t after = 0;  // the index that would follow the last one
  ReplaySource::Tick scripted;
  while (!stop.load(std::memory_order_relaxed)) {
    const ReplaySource::Next next = script.next(scripted);
    if (next == ReplaySource::Next::kEnd) break;
    if (next == ReplaySource::Next::kNotYet) {
      due_ns = std::max(due_ns, monotonicNow_ns());
      sleepUntil(due_ns + period_ns_);
      continue;
    }
    const std::uint64_t missed = after == 0 ? 0 : scripted.index - after;
    add(statistics_.missedTicks, missed);
    after = scripted.index + 1;
    due_ns += (std::min(missed, longestPause) + 1) * period_ns_;
    sleepUntil(due_ns);
    const std::uint64_t now_ns = monotonicNow_ns();
    statistics_.wakeLatency_ns.record(now_ns - std::min(due_ns, now_ns));
    tick(scripted.index, now_ns, scripted.newest);
    script.releaseBefore(scene_->number);
  }
  device_.stop();
}

void ServoLoop::runFlatOut(const std::atomic<bool>& stop) noexcept {
  secondBegan_ns_ = monotonicNow_ns();
  for (std::uint64_t index = 0; !stop.load(std::memory_order_relaxed); ++index) {
    tick(index, monotonicNow_ns(), mailbox_.newest());
  }
  device_.stop();
}

/// @return The time after it.
std::uint64_t ServoLoop::waitForSample(std::uint64_t due_ns, std::uint64_t now_ns) noexcept {
  while (sampleWait_.waits(device_.hasNewSample(), now_ns - due_ns)) {
    sleepUntil(now_ns + sampleWait_.step_ns());
    now_ns = monotonicNow_ns();
  }
  return now_ns;
}

void ServoLoop::tick(std::uint64_t index, std::uint64_t now_ns, const ServoScene* newest) noexcept {
  const AllocationTripwire armed;
  if (flight_ != nullptr) flight_->beginTick(state_, scene_->number, next_ != nullptr ? next_->number : 0);
  if (newest != nullptr) next_ = newest;
  if (next_ != nullptr && adoptScene(*next_, state_, index)) {
    scene_ = std::exchange(next_, nullptr);
    device_.follow(scene_->plan.get());
    mailbox_.adopted();
    statistics_.adoptedRevision.store(scene_->revision, std::memory_order_relaxed);
  }
  if (cacheWarmer_) (*cacheWarmer_)(*scene_, state_);
  ForceResult result;
  const StepInput input{index, now_ns, device_.read(index)};
  computeForce(*scene_, state_, config_, input, result, cacheWarmer_ ? &cacheWarmer_->cache() : nullptr);
  if (state_.features.pendingRemoval) [[unlikely]]
    device_.writeTorque(writtenTorque_Nm(state_));
  device_.write(result.force.written);
  if (cacheWarmer_) cacheWarmer_->note(result.contact.work.allowance);
  finish(input, result, newest != nullptr ? newest->number : 0);
  statistics_.tick_ns.record(monotonicNow_ns() - now_ns);
}

/// Work done after the force is written.
void ServoLoop::finish(const StepInput& input, const ForceResult& result, std::uint64_t newScene) noexcept {
  TelemetrySample sample = finishStep(*scene_, state_, config_, input, result);
  if (flight_ != nullptr) flight_->add({input, newScene, sample.force.written, sample.fault, writtenTorque_Nm(state_)});
  account(sample);
  if (!samples_.push(sample)) add(statistics_.droppedSamples, 1);
  if (state_.features.tool + state_.motion.count + motion_.bodyCount + state_.denting.count + motion_.dentCount > 0)
      [[unlikely]] {
    const bool moved = describeMotion(state_, input.tick, motion_);
    const auto staying = motion_.staying;
    const std::uint64_t revision = motion_.sceneRevision;
    if (describeDents(state_, input.tick, motion_) || moved) motionOut_.put(motion_);
    if (moved || staying != motion_.staying || revision != motion_.sceneRevision) motionToBuilder_.put(motion_);
  }
  if (input.time_ns - energyPublished_ns_ >= kEnergyEvery_ns) [[unlikely]] {
    energyPublished_ns_ = input.time_ns;
    state_.energy.describe(energy_);
    energyOut_.put(energy_);
  }
}

void ServoLoop::account(TelemetrySample& sample) noexcept {
  const std::uint64_t now_ns = sample.time_ns;
  add(statistics_.ticks, 1);
  if (sample.object != 0) add(statistics_.contactTicks, 1);
  if (const double force = glm::length(sample.force.written);
      force > statistics_.maxForce_N.load(std::memory_order_relaxed)) {
    statistics_.maxForce_N.store(force, std::memory_order_relaxed);
  }
  if (now_ns - secondBegan_ns_ >= kSecond_ns) {
    const std::uint64_t ticks = statistics_.ticks.load(std::memory_order_relaxed);
    statistics_.rate_Hz.store(
        static_cast<double>(ticks - ticksBefore_) * 1e9 / static_cast<double>(now_ns - secondBegan_ns_),
        std::memory_order_relaxed);
    ticksBefore_ = ticks;
    secondBegan_ns_ = now_ns;
  }
  if (sample.fault != statistics_.fault.load(std::memory_order_relaxed)) {
    if (sample.fault != Fault::kNone) add(statistics_.faults, 1);
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
  sample.missedTicks = statistics_.missedTicks.load(std::memory_order_relaxed);
  sample.droppedSamples = statistics_.droppedSamples.load(std::memory_order_relaxed);
  sample.servoRate_Hz = statistics_.rate_Hz.load(std::memory_order_relaxed);
}

}  // namespace haptics

#include "haptic_server/servo/servo_loop.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <ctime>

#include "common/clock/monotonic.h"
#include "haptic_server/servo/allocation_tripwire.h"

namespace haptics {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;
/// Longest pause that a replay repeats.
constexpr std::uint64_t kLongestPause_ns = kSecond_ns;

void sleepUntil(std::uint64_t deadline_ns) noexcept {
  const timespec deadline{static_cast<time_t>(deadline_ns / kSecond_ns), static_cast<long>(deadline_ns % kSecond_ns)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) == EINTR) {
  }
}

}  // namespace

ServoLoop::ServoLoop(Device& device, SceneMailbox& mailbox, const StepConfig& config, bool withCacheWarmer)
    : mailbox_(mailbox),
      period_ns_(static_cast<std::uint64_t>(std::llround(static_cast<double>(kSecond_ns) * config.period_s))),
      withCacheWarmer_(withCacheWarmer),
      first_(device, config, withCacheWarmer) {}

void ServoLoop::addHand(Device& device, const StepConfig& config) {
  second_ = std::make_unique<ServoHand>(device, config, withCacheWarmer_);
  second_->followFirst();
}

void ServoLoop::run(const std::atomic<bool>& stop, std::uint64_t maxTicks) noexcept {
  const std::uint64_t start_ns = monotonicNow_ns() + period_ns_;
  secondBegan_ns_ = start_ns;
  for (std::uint64_t index = 0; (maxTicks == 0 || index < maxTicks) && !stop.load(std::memory_order_relaxed); ++index) {
    sleepUntil(start_ns + index * period_ns_);
    std::uint64_t now_ns = monotonicNow_ns();
    if (const std::uint64_t current = (now_ns - start_ns) / period_ns_; current > index) {
      increment(statistics_.missedTicks, current - index);
      index = current;
    }
    const std::uint64_t due_ns = start_ns + index * period_ns_;
    statistics_.wakeLatency_ns.record(now_ns - due_ns);
    now_ns = waitForSample(due_ns, now_ns);
    tick(index, now_ns, mailbox_.newest());
  }
  stopDevices();
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
    increment(statistics_.missedTicks, missed);
    after = scripted.index + 1;
    due_ns += (std::min(missed, longestPause) + 1) * period_ns_;
    sleepUntil(due_ns);
    const std::uint64_t now_ns = monotonicNow_ns();
    statistics_.wakeLatency_ns.record(now_ns - std::min(due_ns, now_ns));
    tick(scripted.index, now_ns, scripted.newest);
    releaseScenes(script);
  }
  stopDevices();
}

/// That no hand uses any more.
void ServoLoop::releaseScenes(ReplaySource& script) const noexcept {
  script.releaseBefore(second_ ? std::min(first_.scene().number, second_->scene().number) : first_.scene().number);
}

void ServoLoop::runFlatOut(ReplaySource& script) noexcept {
  ReplaySource::Tick scripted;
  for (auto next = script.next(scripted); next != ReplaySource::Next::kEnd; next = script.next(scripted)) {
    if (next == ReplaySource::Next::kNotYet) {
      sleepUntil(monotonicNow_ns() + period_ns_);
      continue;
    }
    tick(scripted.index, scripted.index * period_ns_, scripted.newest);
    releaseScenes(script);
  }
  stopDevices();
}

void ServoLoop::runFlatOut(const std::atomic<bool>& stop) noexcept {
  secondBegan_ns_ = monotonicNow_ns();
  for (std::uint64_t index = 0; !stop.load(std::memory_order_relaxed); ++index) {
    tick(index, monotonicNow_ns(), mailbox_.newest());
  }
  stopDevices();
}

/// Of every device: a position that read() has not given yet.
bool ServoLoop::hasNewSample() noexcept {
  return first_.device().hasNewSample() && (!second_ || second_->device().hasNewSample());
}

/// @return The time after it.
std::uint64_t ServoLoop::waitForSample(std::uint64_t due_ns, std::uint64_t now_ns) noexcept {
  while (sampleWait_.shouldWait(hasNewSample(), now_ns - due_ns)) {
    sleepUntil(now_ns + sampleWait_.step_ns());
    now_ns = monotonicNow_ns();
  }
  return now_ns;
}

void ServoLoop::tick(std::uint64_t index, std::uint64_t now_ns, const ServoScene* newest) noexcept {
  const AllocationTripwire armed;
  if (flight_ != nullptr) beginRecording();
  adopt(index, newest);
  first_.rehearse();
  if (second_) second_->rehearse();
  first_.computeForce(index, now_ns);
  if (second_) second_->computeForce(index, now_ns);
  account(now_ns);
  finish(newest != nullptr ? newest->number : 0);
  statistics_.tick_ns.record(monotonicNow_ns() - now_ns);
}

void ServoLoop::adopt(std::uint64_t index, const ServoScene* newest) noexcept {
  bool any = first_.adopt(newest, index);
  if (second_) any = second_->adopt(newest, index) || any;
  if (!any || first_.hasPendingScene() || (second_ && second_->hasPendingScene())) return;
  mailbox_.adopted();
  statistics_.adoptedRevision.store(first_.scene().revision, std::memory_order_relaxed);
}

void ServoLoop::beginRecording() noexcept {
  if (!second_) return flight_->beginTick(std::array{first_.moment()});
  flight_->beginTick(std::array{first_.moment(), second_->moment()});
}

/// Work done after the forces are written.
void ServoLoop::finish(std::uint64_t newScene) noexcept {
  const HandTick first = first_.handTick();
  TelemetrySample sample;
  if (!second_) {
    sample = finishStep(first.scene, first.state, first.config, first.input, first.result);
    if (flight_ != nullptr) flight_->add(std::array{first_.recorded(newScene, sample)});
    return publish(first_, sample);
  }
  TelemetrySample secondSample;
  finishSteps(first, second_->handTick(), sample, secondSample);
  if (flight_ != nullptr)
    flight_->add(std::array{first_.recorded(newScene, sample), second_->recorded(newScene, secondSample)});
  publish(*second_, secondSample);  // first: who takes the first hand's sample finds this one
  publish(first_, sample);
}

void ServoLoop::publish(ServoHand& hand, TelemetrySample& sample) noexcept {
  sample.handle = hand.handle();
  sample.missedTicks = statistics_.missedTicks.load(std::memory_order_relaxed);
  sample.droppedSamples = hand.statistics().droppedSamples.load(std::memory_order_relaxed);
  sample.servoRate_Hz = statistics_.rate_Hz.load(std::memory_order_relaxed);
  hand.publish(sample);
}

void ServoLoop::account(std::uint64_t now_ns) noexcept {
  increment(statistics_.ticks, 1);
  if (now_ns - secondBegan_ns_ < kSecond_ns) return;
  const std::uint64_t ticks = statistics_.ticks.load(std::memory_order_relaxed);
  statistics_.rate_Hz.store(
      static_cast<double>(ticks - ticksBefore_) * 1e9 / static_cast<double>(now_ns - secondBegan_ns_),
      std::memory_order_relaxed);
  ticksBefore_ = ticks;
  secondBegan_ns_ = now_ns;
}

void ServoLoop::stopDevices() noexcept {
  first_.stop();
  if (second_) second_->stop();
}

}  // namespace haptics

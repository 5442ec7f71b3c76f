#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/mailbox/triple_buffer.h"
#include "common/telemetry/motion_state.h"
#include "common/telemetry/telemetry_sample.h"
#include "haptic_server/device/device.h"
#include "haptic_server/engine/step/kinematic_motion.h"
#include "haptic_server/engine/step/two_hands.h"
#include "haptic_server/servo/cache_warmer.h"
#include "haptic_server/servo/flight_ring.h"

namespace haptics {

/// Counters of one hand. The servo thread writes, any thread reads; each value is whole, their set is not.
struct HandStatistics {
  std::atomic<std::uint64_t> contactTicks{0};
  std::atomic<std::uint64_t> depenetrated{0};  ///< As in TelemetrySample.
  std::atomic<std::uint64_t> depenetratedFrom{0};
  std::atomic<std::uint64_t> allowanceSpent{0};  ///< As in TelemetrySample.
  std::atomic<double> wait_s{0};                 ///< Likewise.
  std::atomic<std::uint64_t> droppedSamples{0};
  std::atomic<double> maxForce_N{0};  ///< Largest force written.
  std::atomic<Fault> fault{Fault::kNone};
  std::atomic<DeviceFault> deviceFault{DeviceFault::kNone};
  std::atomic<std::uint64_t> faults{0};  ///< How often one began.
};

/// Adds to a counter that only the servo thread writes.
inline void increment(std::atomic<std::uint64_t>& counter, std::uint64_t n) noexcept {
  counter.store(counter.load(std::memory_order_relaxed) + n, std::memory_order_relaxed);
}

/// A device in the servo loop, the step's state for the hand that holds it, and its outputs to other threads. The servo
/// thread calls all that names no other thread.
class ServoHand {
 public:
  /// Ticks held for the network thread: 4 s at 1 kHz, 200 ms at 20 kHz. When it is full, new samples are dropped and
  /// counted.
  static constexpr std::size_t kQueuedSamples = 4096;

  /// The device outlives it. Without the cache warmer the forces are the same, only later.
  ServoHand(Device& device, const StepConfig& config, bool withCacheWarmer);

  /// Its bodies go where those of the first hand go. Before the first tick.
  void followFirst() noexcept { followFirstHand(state_); }
  /// Goes on from this state; before the first tick. `scene`: that it had adopted, null for the empty one; `pending`: that
  /// it was still to adopt, null for none.
  void resumeFrom(const HapticState& state, const ServoScene* scene, const ServoScene* pending) noexcept;

  /// At a tick's start. `newest`: the scene that came since the last one, null for none. @return Whether one was adopted.
  [[nodiscard]] bool adopt(const ServoScene* newest, std::uint64_t tick) noexcept;
  /// A scene waits until the contact that adopting it would break has faded.
  [[nodiscard]] bool hasPendingScene() const noexcept { return next_ != nullptr; }
  /// Warms the caches, while the device's position is not yet known.
  void rehearse() noexcept {
    if (cacheWarmer_) (*cacheWarmer_)(*scene_, state_);
  }
  /// From the device's position to the force that is written to it.
  void computeForce(std::uint64_t tick, std::uint64_t now_ns) noexcept;
  /// For finishStep() or finishSteps().
  [[nodiscard]] HandTick handTick() noexcept { return {*scene_, state_, config_, input_, result_}; }
  /// The record of the finished tick. `newScene`: the number of the scene that came, 0 for none.
  [[nodiscard]] RecordedTick recorded(std::uint64_t newScene, const TelemetrySample& sample) const noexcept;
  /// Queues the sample of the finished tick; publishes poses of moving bodies, dents and energies.
  void publish(const TelemetrySample& sample) noexcept;
  void stop() noexcept { device_.stop(); }

  [[nodiscard]] Device& device() noexcept { return device_; }
  /// As read in the last tick.
  [[nodiscard]] const HandleReading& handle() const noexcept { return handle_; }
  [[nodiscard]] const StepConfig& config() const noexcept { return config_; }
  [[nodiscard]] const ServoScene& scene() const noexcept { return *scene_; }
  [[nodiscard]] StateMoment moment() const noexcept {
    return {&state_, scene_->number, next_ != nullptr ? next_->number : 0};
  }
  /// Any thread.
  [[nodiscard]] const HandStatistics& statistics() const noexcept { return statistics_; }

  /// For one consumer thread, wait-free: the oldest queued sample. False when there is none.
  [[nodiscard]] bool pop(TelemetrySample& sample) noexcept { return samples_.pop(sample); }
  /// For that thread too, wait-free: where the objects that move are, and the dents that this hand has made; null when
  /// nothing has changed since the last call. Comes after the sample of its tick. A scene in which nothing moves has none.
  [[nodiscard]] const MotionState* takeMotion() noexcept { return motionOut_.takeNew(); }
  /// The same of shapes that are driven.
  [[nodiscard]] const ShapePlaces* takeShapes() noexcept { return shapesOut_.takeNew(); }
  /// The same for the builder thread, which plans by it what a simulated hand explores, and bakes the dents that stay;
  /// null when neither has changed.
  [[nodiscard]] const MotionState* takeMotionForBuilder() noexcept { return motionToBuilder_.takeNew(); }
  /// For the consumer of samples, wait-free: what the objects gave the hand, 50 times a second; null in between.
  [[nodiscard]] const EnergyState* takeEnergy() noexcept { return energyOut_.takeNew(); }
  /// As it was at last, once the servo has ended.
  [[nodiscard]] const MotionState& lastMotion() const noexcept { return motion_; }

 private:
  void account(const TelemetrySample& sample) noexcept;
  void writeTorque() noexcept;
  void publishMotion(std::uint64_t tick) noexcept;

  Device& device_;
  StepConfig config_;
  HapticState state_;
  std::optional<CacheWarmer> cacheWarmer_;
  ServoScene empty_;
  const ServoScene* scene_ = &empty_;
  const ServoScene* next_ = nullptr;  // to be adopted, once the contact that it would break has faded out
  StepInput input_;
  HandleReading handle_;
  AddedWrench added_;
  ForceResult result_;
  HandStatistics statistics_;
  MotionState motion_;
  TripleBuffer<MotionState> motionOut_, motionToBuilder_;
  ShapePlaces shapes_;
  TripleBuffer<ShapePlaces> shapesOut_;
  EnergyState energy_;
  TripleBuffer<EnergyState> energyOut_;
  std::uint64_t energyPublished_ns_ = 0;
  boost::lockfree::spsc_queue<TelemetrySample, boost::lockfree::capacity<kQueuedSamples>> samples_;
};

}  // namespace haptics

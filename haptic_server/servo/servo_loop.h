#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <memory>
#include <optional>

#include "common/mailbox/triple_buffer.h"
#include "common/telemetry/motion_state.h"
#include "common/telemetry/telemetry_sample.h"
#include "haptic_server/device/device.h"
#include "haptic_server/servo/cache_warmer.h"
#include "haptic_server/servo/flight_ring.h"
#include "haptic_server/servo/latency_histogram.h"
#include "haptic_server/servo/replay_source.h"
#include "haptic_server/servo/sample_wait.h"
#include "haptic_server/servo/scene_mailbox.h"
#include "haptic_server/servo/server_step_config.h"
#include "haptic_server/step/haptic_step.h"

namespace haptics {

/// What the servo tells about itself. The servo thread writes, any thread reads; each value is whole, their set is not.
struct ServoStatistics {
  std::atomic<std::uint64_t> ticks{0};
  std::atomic<std::uint64_t> missedTicks{0};
  std::atomic<std::uint64_t> contactTicks{0};
  std::atomic<std::uint64_t> depenetrated{0};  ///< As in TelemetrySample.
  std::atomic<std::uint64_t> depenetratedFrom{0};
  std::atomic<std::uint64_t> allowanceSpent{0};  ///< As in TelemetrySample.
  std::atomic<double> wait_s{0};                 ///< Likewise.
  std::atomic<std::uint64_t> adoptedRevision{0};
  std::atomic<std::uint64_t> droppedSamples{0};
  std::atomic<double> maxForce_N{0};  ///< Largest force written.
  std::atomic<double> rate_Hz{0};     ///< Ticks run in the last second.
  std::atomic<Fault> fault{Fault::kNone};
  std::atomic<DeviceFault> deviceFault{DeviceFault::kNone};
  std::atomic<std::uint64_t> faults{0};  ///< How often one began.
  LatencyHistogram tick_ns;              ///< Wake-up to force written and sample queued.
  LatencyHistogram wakeLatency_ns;       ///< Deadline to wake-up.
};

/// The servo loop: wakes on an absolute clock at a fixed rate, waits for a position that is a little late, adopts a scene
/// if there is a new one, pre-touches what the tick will read, reads the device, feels the force and writes it; then
/// finishes the step, records it and queues the sample. After start-up it neither allocates nor locks nor wakes a thread.
class ServoLoop {
 public:
  /// Ticks held for the network thread: 4 s at 1 kHz, 200 ms at 20 kHz. When it is full, new samples are dropped and
  /// counted.
  static constexpr std::size_t kQueuedSamples = 4096;

  /// `device` and `crossing` outlive the loop. Without pre-touch the forces are the same, only later.
  ServoLoop(Device& device, SceneMailbox& mailbox, const StepConfig& config, bool withCacheWarmer = true);
  /// With serverStepConfig().
  ServoLoop(Device& device, SceneMailbox& mailbox, double rate_Hz, bool withCacheWarmer = true)
      : ServoLoop(device, mailbox, serverStepConfig(device.info(), rate_Hz), withCacheWarmer) {}

  /// Every tick goes into this ring, which outlives the loop. Before run().
  void recordInto(FlightRing& ring) noexcept { flight_ = &ring; }

  /// Runs on the calling thread until `stop` is set or `maxTicks` periods (0: no end) have passed; stops the device.
  /// A tick whose whole period was slept through is skipped and counted; there is no burst to catch up.
  void run(const std::atomic<bool>& stop, std::uint64_t maxTicks = 0) noexcept;

  /// Goes on from this state; before run(). `scene`: that it had adopted, null for the empty one; `pending`: that it was
  /// still to adopt, null for none.
  void resumeFrom(const HapticState& state, const ServoScene* scene, const ServoScene* pending) noexcept;
  /// As run(), with the ticks of a script, each as long after the one before as it was then; those that it left out
  /// count as missed. To its end, or until `stop`. What the servo slept through it catches up with: nobody holds a device.
  void run(ReplaySource& script, const std::atomic<bool>& stop) noexcept;

  /// As run(), but begins each tick as soon as the last one is done: for measuring what the machine can do.
  void runFlatOut(const std::atomic<bool>& stop) noexcept;

  [[nodiscard]] const ServoStatistics& statistics() const noexcept { return statistics_; }
  /// For one consumer thread, wait-free: the oldest queued sample. False when there is none.
  [[nodiscard]] bool pop(TelemetrySample& sample) noexcept { return samples_.pop(sample); }
  /// For that thread too, wait-free: where the objects that move are, null when nothing has changed since the last call.
  /// Comes after the sample of its tick. A scene in which nothing moves has none.
  [[nodiscard]] const MotionState* takeMotion() noexcept { return motionOut_.takeNew(); }
  /// The same for the builder thread, which plans by it what a simulated hand explores, and bakes the dents that stay;
  /// null when neither has changed.
  [[nodiscard]] const MotionState* takeMotionForBuilder() noexcept { return motionToBuilder_.takeNew(); }
  /// For the consumer of samples, wait-free: what the objects gave the hand, 50 times a second; null in between.
  [[nodiscard]] const EnergyState* takeEnergy() noexcept { return energyOut_.takeNew(); }
  /// As it was at last, once run() has returned.
  [[nodiscard]] const MotionState& lastMotion() const noexcept { return motion_; }
  [[nodiscard]] const StepConfig& config() const noexcept { return config_; }

 private:
  /// @param newest  The scene that came since the last tick, null for none.
  void tick(std::uint64_t index, std::uint64_t now_ns, const ServoScene* newest) noexcept;
  void finish(const StepInput& input, const ForceResult& result, std::uint64_t newScene) noexcept;
  [[nodiscard]] std::uint64_t waitForSample(std::uint64_t due_ns, std::uint64_t now_ns) noexcept;
  void account(TelemetrySample& sample) noexcept;

  Device& device_;
  SceneMailbox& mailbox_;
  StepConfig config_;
  std::uint64_t period_ns_;
  SampleWait sampleWait_{period_ns_};
  HapticState state_;
  std::optional<CacheWarmer> cacheWarmer_;
  ServoScene empty_;
  const ServoScene* scene_ = &empty_;
  const ServoScene* next_ = nullptr;  // to be adopted, once the contact that it would break has faded out
  ServoStatistics statistics_;
  std::uint64_t secondBegan_ns_ = 0;
  std::uint64_t ticksBefore_ = 0;
  MotionState motion_;
  TripleBuffer<MotionState> motionOut_, motionToBuilder_;
  EnergyState energy_;
  TripleBuffer<EnergyState> energyOut_;
  std::uint64_t energyPublished_ns_ = 0;
  FlightRing* flight_ = nullptr;
  boost::lockfree::spsc_queue<TelemetrySample, boost::lockfree::capacity<kQueuedSamples>> samples_;
};

}  // namespace haptics

#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "haptic_server/servo/flight_ring.h"
#include "haptic_server/servo/latency_histogram.h"
#include "haptic_server/servo/replay_source.h"
#include "haptic_server/servo/sample_wait.h"
#include "haptic_server/servo/scene_mailbox.h"
#include "haptic_server/servo/server_step_config.h"
#include "haptic_server/servo/servo_hand.h"

namespace haptics {

/// Counters of the servo loop; HandStatistics has those of each hand. The servo thread writes, any thread reads; each value is
/// whole, their set is not.
struct ServoStatistics {
  std::atomic<std::uint64_t> ticks{0};
  std::atomic<std::uint64_t> missedTicks{0};
  std::atomic<std::uint64_t> adoptedRevision{0};  ///< By every hand.
  std::atomic<double> rate_Hz{0};                 ///< Ticks run in the last second.
  LatencyHistogram tick_ns;                       ///< Wake-up to forces written and samples queued.
  LatencyHistogram wakeLatency_ns;                ///< Deadline to wake-up.
};

/// The servo loop: wakes on an absolute clock at a fixed rate, waits for a position that is a little late, adopts a scene
/// if there is a new one, warms the caches, reads the device, computes the force and writes it; then
/// finishes the step, records it and queues the sample. The same for a second hand in the same tick, where there is one
/// (two_hands.h). After start-up it neither allocates nor locks nor wakes a thread.
class ServoLoop {
 public:
  /// `device` and `mailbox` outlive the loop. Without the cache warmer the forces are the same, only later.
  ServoLoop(Device& device, SceneMailbox& mailbox, const StepConfig& config, bool withCacheWarmer = true);
  /// With serverStepConfig().
  ServoLoop(Device& device, SceneMailbox& mailbox, double rate_Hz, bool withCacheWarmer = true)
      : ServoLoop(device, mailbox, serverStepConfig(device.info(), rate_Hz), withCacheWarmer) {}

  /// A second hand, whose device outlives the loop. Before run(); its period is the first hand's.
  void addHand(Device& device, const StepConfig& config);

  /// Every tick goes into this ring, of as many hands, which outlives the loop. Before run().
  void recordInto(FlightRing& ring) noexcept { flight_ = &ring; }

  /// Runs on the calling thread until `stop` is set or `maxTicks` periods (0: no end) have passed; stops the devices.
  /// A tick whose whole period was slept through is skipped and counted; there is no burst to catch up.
  void run(const std::atomic<bool>& stop, std::uint64_t maxTicks = 0) noexcept;

  /// As run(), with the ticks of a script, each as long after the one before as it was then; those that it left out
  /// count as missed. To its end, or until `stop`. What the servo slept through it catches up with: nobody holds a device.
  void run(ReplaySource& script, const std::atomic<bool>& stop) noexcept;

  /// The same in the ticks' own time, each as soon as the last one is done. Forces are those of run().
  void runFlatOut(ReplaySource& script) noexcept;

  /// As run(), but begins each tick as soon as the last one is done: for measuring what the machine can do.
  void runFlatOut(const std::atomic<bool>& stop) noexcept;

  [[nodiscard]] const ServoStatistics& statistics() const noexcept { return statistics_; }
  [[nodiscard]] ServoHand& hand() noexcept { return first_; }
  [[nodiscard]] const ServoHand& hand() const noexcept { return first_; }
  /// Null: there is none.
  [[nodiscard]] ServoHand* secondHand() noexcept { return second_.get(); }
  [[nodiscard]] const StepConfig& config() const noexcept { return first_.config(); }

 private:
  /// @param newest  The scene that came since the last tick, null for none.
  void tick(std::uint64_t index, std::uint64_t now_ns, const ServoScene* newest) noexcept;
  void adopt(std::uint64_t index, const ServoScene* newest) noexcept;
  void releaseScenes(ReplaySource& script) const noexcept;
  void beginRecording() noexcept;
  void finish(std::uint64_t newScene) noexcept;
  [[nodiscard]] bool hasNewSample() noexcept;
  [[nodiscard]] std::uint64_t waitForSample(std::uint64_t due_ns, std::uint64_t now_ns) noexcept;
  void account(std::uint64_t now_ns) noexcept;
  void publish(ServoHand& hand, TelemetrySample& sample) noexcept;
  void stopDevices() noexcept;

  SceneMailbox& mailbox_;
  std::uint64_t period_ns_;
  bool withCacheWarmer_;
  SampleWait sampleWait_{period_ns_};
  ServoHand first_;
  std::unique_ptr<ServoHand> second_;
  ServoStatistics statistics_;
  std::uint64_t secondBegan_ns_ = 0;
  std::uint64_t ticksBefore_ = 0;
  FlightRing* flight_ = nullptr;
};

}  // namespace haptics

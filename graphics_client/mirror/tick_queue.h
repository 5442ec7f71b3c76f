#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <utility>

#include "graphics_client/mirror/client_callbacks.h"

namespace haptics {

/// Ticks from the link's thread to the one that writes them. Bounded: what comes while it is full is left out, and so a gap
/// between what is taken.
class TickQueue {
 public:
  static constexpr std::size_t kTicks = 1U << 16;  ///< 65 s at 1 kHz, some 30 MB.

  struct Tick {
    v1::Telemetry sample;
    bool tellsAll = false;  ///< Bodies, dents and tool came with it, as far as there are any.
  };

  /// Link's thread.
  void put(const v1::TelemetryBatch& batch) {
    const std::lock_guard lock(mutex_);
    const std::size_t room = kTicks - std::min(kTicks, ticks_.size());
    const auto count = std::min(room, static_cast<std::size_t>(batch.sample_size()));
    for (std::size_t i = 0; i < count; ++i) {
      const auto at = static_cast<int>(i);
      ticks_.push_back({batch.sample(at), batch.reaches_newest() && at + 1 == batch.sample_size()});
    }
    some_.notify_all();
  }
  /// All that there are; none after the timeout.
  [[nodiscard]] std::deque<Tick> take(std::chrono::nanoseconds timeout) {
    std::unique_lock lock(mutex_);
    some_.wait_for(lock, timeout, [this] { return !ticks_.empty(); });
    return std::exchange(ticks_, {});
  }

 private:
  std::mutex mutex_;
  std::condition_variable some_;
  std::deque<Tick> ticks_;
};

}  // namespace haptics

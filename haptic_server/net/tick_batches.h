#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "common/wire/convert.h"
#include "haptic_server/net/tick_history.h"

namespace haptics {

/// One client's way through the ticks, where it wants every one.
class TickBatches {
 public:
  /// A batch goes out so often, or when so many ticks have come together.
  static constexpr std::uint64_t kEvery_ns = 10'000'000;
  static constexpr std::uint64_t kTicks = 128;

  void start(const TickHistory& ticks) noexcept { next_ = ticks.end(); }  ///< From the next tick on.
  void stop() noexcept { next_.reset(); }
  [[nodiscard]] bool wanted() const noexcept { return next_.has_value(); }

  /// Fills a batch with the ticks whose turn it is, without what is known of the newest tick only.
  /// @return False: none is due.
  [[nodiscard]] bool take(const TickHistory& ticks, std::uint64_t now_ns, v1::TelemetryBatch& batch) {
    std::uint64_t& next = *next_;
    next = std::max(next, ticks.begin());
    const std::uint64_t end = std::min(ticks.end(), next + kTicks);
    if (next == end || (end - next < kTicks && now_ns < due_ns_)) return false;
    due_ns_ = now_ns + kEvery_ns;
    batch.Clear();
    for (; next < end; ++next) {
      const TickHistory::Tick& tick = ticks.at(next);
      v1::Telemetry& message = *batch.add_sample();
      toWire(tick.sample, message);
      if (tick.second) toWireOfSecondHand(*tick.second, message);
    }
    batch.set_reaches_newest(end == ticks.end());
    return true;
  }

 private:
  std::optional<std::uint64_t> next_;  // position; nothing: the client does not want them
  std::uint64_t due_ns_ = 0;
};

}  // namespace haptics

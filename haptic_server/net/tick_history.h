#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/telemetry/telemetry_sample.h"

namespace haptics {

/// The newest ticks, for clients that want every one: each reads on from its own position. Kept only while there is such a
/// client. Network thread.
class TickHistory {
 public:
  static constexpr std::size_t kTicks = 16'384;  ///< As telemetry.proto says.

  struct Tick {
    TelemetrySample sample;
    std::optional<TelemetrySample> second;  ///< Of a second hand.
  };

  /// Nothing is kept while nobody wants it.
  void keep(bool wanted) {
    if (wanted == isKept()) return;
    ticks_ = std::vector<Tick>(wanted ? kTicks : 0);
    begin_ = end_;
  }
  [[nodiscard]] bool isKept() const noexcept { return !ticks_.empty(); }

  /// @param second  Null: there is none.
  void add(const TelemetrySample& sample, const TelemetrySample* second) {
    if (!isKept()) return;
    Tick& tick = ticks_[end_++ % kTicks];
    tick.sample = sample;
    tick.second = second == nullptr ? std::nullopt : std::optional(*second);
    if (end_ - begin_ > kTicks) ++begin_;
  }

  /// Positions of the ticks that are here; they count up for ever.
  [[nodiscard]] std::uint64_t begin() const noexcept { return begin_; }
  [[nodiscard]] std::uint64_t end() const noexcept { return end_; }
  [[nodiscard]] const Tick& at(std::uint64_t position) const { return ticks_[position % kTicks]; }

 private:
  std::vector<Tick> ticks_;
  std::uint64_t begin_ = 0, end_ = 0;
};

}  // namespace haptics

#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace haptics {

/// Ticks that are not there between two samples that follow each other in a stream of every tick.
struct TickGap {
  std::uint64_t after = 0;   ///< The tick before.
  std::uint64_t missed = 0;  ///< That the servo slept through: nothing was computed.
  std::uint64_t lost = 0;    ///< That were computed, and lost on the way here.

  /// "after tick 4711: 3 missed by the servo, 120 lost on the way".
  [[nodiscard]] std::string inWords() const {
    std::string words = "after tick " + std::to_string(after) + ": ";
    if (missed > 0) words += std::to_string(missed) + " missed by the servo";
    if (missed > 0 && lost > 0) words += ", ";
    if (lost > 0) words += std::to_string(lost) + " lost on the way";
    return words;
  }
};

/// Finds the gaps of a stream of every tick.
class TickGaps {
 public:
  /// The next sample. @param missed  TelemetrySample::missedTicks. @return What is missing before it.
  std::optional<TickGap> next(std::uint64_t tick, std::uint64_t missed) noexcept {
    std::optional<TickGap> gap;
    if (any_ && tick > tick_ + 1) {
      const std::uint64_t between = tick - tick_ - 1;
      const std::uint64_t slept = missed > missed_ ? missed - missed_ : 0;
      gap = {tick_, slept < between ? slept : between, slept < between ? between - slept : 0};
      missedInAll_ += gap->missed;
      lost_ += gap->lost;
    }
    any_ = true;
    tick_ = tick;
    missed_ = missed;
    return gap;
  }
  [[nodiscard]] std::uint64_t missed() const noexcept { return missedInAll_; }  ///< Since the first sample,
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }           ///< likewise.

 private:
  bool any_ = false;
  std::uint64_t tick_ = 0, missed_ = 0, missedInAll_ = 0, lost_ = 0;
};

}  // namespace haptics

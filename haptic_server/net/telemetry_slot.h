#pragma once

#include <algorithm>
#include <cstdint>

#include "common/telemetry/telemetry_sample.h"

namespace haptics {

/// One client's newest sample, and when it may be sent. Latest wins: a sample that was not sent is replaced.
class TelemetrySlot {
 public:
  /// Longest time between samples, however low the rate that was asked for.
  static constexpr double kLongestPeriod_s = 3600;

  /// Samples a second; 0: none.
  void setRate(double rate_Hz) noexcept {
    period_ns_ = rate_Hz > 0 ? static_cast<std::uint64_t>(1e9 * std::min(1 / rate_Hz, kLongestPeriod_s)) : 0;
    next_ns_ = 0;
  }
  [[nodiscard]] double rate_Hz() const noexcept { return period_ns_ == 0 ? 0 : 1e9 / static_cast<double>(period_ns_); }
  /// @param second  Of a second hand, of the same tick; null: there is none.
  void offer(const TelemetrySample& sample, const TelemetrySample* second) noexcept {
    newest_ = sample;
    hasSecond_ = second != nullptr;
    if (hasSecond_) second_ = *second;
    fresh_ = true;
  }
  [[nodiscard]] bool due(std::uint64_t now_ns) const noexcept {
    return fresh_ && period_ns_ != 0 && now_ns >= next_ns_;
  }
  /// The sample that is due. The rate is kept on average; what was missed is not made up for.
  [[nodiscard]] const TelemetrySample& take(std::uint64_t now_ns) noexcept {
    fresh_ = false;
    next_ns_ += period_ns_;
    if (next_ns_ <= now_ns) next_ns_ = now_ns + period_ns_;
    return newest_;
  }
  /// The second hand's of the sample that take() gave last; null: there is none.
  [[nodiscard]] const TelemetrySample* second() const noexcept { return hasSecond_ ? &second_ : nullptr; }

 private:
  TelemetrySample newest_, second_;
  bool hasSecond_ = false;
  bool fresh_ = false;
  std::uint64_t period_ns_ = 0;
  std::uint64_t next_ns_ = 0;
};

}  // namespace haptics

#pragma once

#include <chrono>
#include <cstdint>

namespace haptics {

constexpr std::uint64_t kNanosecondsPerMillisecond = 1'000'000;

/// Nanoseconds on this host's monotonic clock, the one that clock_nanosleep(CLOCK_MONOTONIC) waits on.
[[nodiscard]] inline std::uint64_t monotonicNow_ns() noexcept {
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
}

}  // namespace haptics

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "haptic_server/servo/realtime.h"

namespace haptics {

/// Wake-ups of a thread that sleeps as the servo does.
struct WakeUps {
  struct Bin {
    std::uint64_t below_ns;  ///< Not this late, but as late as the bin before says.
    std::uint64_t count = 0;
  };
  RealtimeStatus realtime;
  std::uint64_t count = 0;
  std::uint64_t late = 0;  ///< By a period or more: the servo would have missed ticks.
  std::uint64_t p50_ns = 0, p99_ns = 0, p999_ns = 0, max_ns = 0;
  std::vector<Bin> bins;  ///< The last one holds all that are later.
};

/// Measures them for a while, on a thread that is made real-time as the servo's is.
[[nodiscard]] WakeUps measureWakeUps(double seconds, double rate_Hz, std::optional<int> cpu);

}  // namespace haptics

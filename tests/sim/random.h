#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

#include "tests/sim/virtual_time.h"

namespace haptics::sim {

/// All chance in a simulated world comes from one of these, and so from its seed.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  [[nodiscard]] std::uint64_t bits() { return engine_() | 1; }  ///< Never 0.
  [[nodiscard]] bool chance(double probability) { return uniform(0, 1) < probability; }
  [[nodiscard]] double uniform(double from, double to) {
    return from + (to - from) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  [[nodiscard]] std::size_t below(std::size_t count) { return static_cast<std::size_t>(engine_() % count); }
  [[nodiscard]] std::uint64_t milliseconds(double from_ms, double to_ms) {
    return static_cast<std::uint64_t>(uniform(from_ms, to_ms) * static_cast<double>(kMillisecond_ns));
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace haptics::sim

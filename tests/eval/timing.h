#pragma once

#include <chrono>
#include <vector>

#include "tests/eval/statistics.h"

namespace haptics::eval {

/// Durations of single events in ns, without what reading the clock adds to each.
class Stopwatch {
 public:
  Stopwatch();

  template <class Event>
  void time(Event event) {
    const auto begin = std::chrono::steady_clock::now();
    event();
    const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - begin;
    durations_ns_.add(std::max(0.0, taken.count() - clock_ns_));
  }
  [[nodiscard]] Statistics& durations_ns() noexcept { return durations_ns_; }

 private:
  double clock_ns_ = 0;  // the median of an event that does nothing
  Statistics durations_ns_;
};

/// That this thread has had of the processor, whatever else the machine did.
[[nodiscard]] double threadTime_s();

/// Reads and writes twice the last level cache, so that nothing else is left in any cache.
void sweepCaches();

}  // namespace haptics::eval

#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <vector>

namespace haptics::bench {

using Clock = std::chrono::steady_clock;

/// The value that this fraction of them does not exceed. Reorders them.
[[nodiscard]] double percentile(std::vector<double>& values, double fraction);

/// Durations of single events, without what reading the clock adds to each.
class Stopwatch {
 public:
  Stopwatch();

  /// Returns the duration, ns.
  template <class Event>
  double time(Event event) {
    const Clock::time_point begin = Clock::now();
    event();
    return record(Clock::now() - begin);
  }
  /// The same for an event that read the clock itself, at its begin and its end.
  double record(std::chrono::duration<double, std::nano> taken) {
    durations_ns_.push_back(std::max(0.0, taken.count() - clock_ns_));
    return durations_ns_.back();
  }
  /// Room for this many, so that record() does not allocate.
  void reserve(std::size_t events) { durations_ns_.reserve(events); }

  /// Adds p50_ns, p99_ns and worst_ns to the benchmark's figures.
  void report(benchmark::State& state);

 private:
  double clock_ns_;  // the median of an event that does nothing
  std::vector<double> durations_ns_;
};

}  // namespace haptics::bench

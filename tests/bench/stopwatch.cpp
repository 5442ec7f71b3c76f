#include "tests/bench/stopwatch.h"

#include <algorithm>

namespace haptics::bench {

double percentile(std::vector<double>& values, double fraction) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Stopwatch::Stopwatch() : clock_ns_(0) {
  constexpr int kRounds = 1001;
  for (int i = 0; i < kRounds; ++i) time([] { benchmark::ClobberMemory(); });
  clock_ns_ = percentile(durations_ns_, 0.5);
  durations_ns_.clear();
}

void Stopwatch::report(benchmark::State& state) {
  state.counters["p50_ns"] = percentile(durations_ns_, 0.5);
  state.counters["p99_ns"] = percentile(durations_ns_, 0.99);
  state.counters["worst_ns"] = percentile(durations_ns_, 1);
}

}  // namespace haptics::bench

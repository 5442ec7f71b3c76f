#include "tests/bench/stopwatch.h"

#include <algorithm>

namespace haptics::bench {
namespace {

std::size_t lastLevelCache_bytes() {
  std::size_t largest = std::size_t{32} << 20;  // where the system does not tell
  for (const auto& cache : benchmark::CPUInfo::Get().caches) {
    largest = std::max(largest, static_cast<std::size_t>(cache.size));
  }
  return largest;
}

}  // namespace

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

void sweepCaches() {
  constexpr std::size_t kCacheLine_bytes = 64;
  static std::vector<std::uint8_t> buffer(2 * lastLevelCache_bytes());
  for (std::size_t i = 0; i < buffer.size(); i += kCacheLine_bytes) ++buffer[i];
  benchmark::ClobberMemory();
}

}  // namespace haptics::bench

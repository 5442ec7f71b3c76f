#include <benchmark/benchmark.h>

#include <vector>

#include "tests/bench/benches.h"
#include "tests/bench/step_replay.h"
#include "tests/bench/stopwatch.h"

namespace haptics::bench {
namespace {

constexpr int kTicksOfTurn = 1'000;  // hot, and the time of the clock itself does not count
constexpr int kPairsOfTurns = 400;

/// Turns with and without the effect, one after the other: the median of what each with it took more, ns a tick.
void effect(benchmark::State& state, StepReplay (*make)()) {
  StepReplay without = inTheOpen(), with = make();
  const auto turn_ns = [](StepReplay& replay) {
    const Clock::time_point begun = Clock::now();
    for (int i = 0; i < kTicksOfTurn; ++i) benchmark::DoNotOptimize(replay.tick());
    return std::chrono::duration<double, std::nano>(Clock::now() - begun).count() / kTicksOfTurn;
  };
  std::vector<double> more_ns, all_ns;
  for (auto _ : state) {
    const double without_ns = turn_ns(without), with_ns = turn_ns(with);
    all_ns.push_back(with_ns);
    more_ns.push_back(with_ns - without_ns);
  }
  state.counters["more_p50_ns"] = percentile(more_ns, 0.5);
  state.counters["tick_p50_ns"] = percentile(all_ns, 0.5);
}

}  // namespace

void registerEffects() {
  benchmark::RegisterBenchmark("effect/spring_to_point", effect, springToPoint)->Iterations(kPairsOfTurns);
  benchmark::RegisterBenchmark("effect/guide_1000_points", effect, guide)->Iterations(kPairsOfTurns);
}

}  // namespace haptics::bench

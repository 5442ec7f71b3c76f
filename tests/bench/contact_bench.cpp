#include <benchmark/benchmark.h>

#include <string>

#include "tests/bench/benches.h"
#include "tests/bench/scenes.h"
#include "tests/bench/step_replay.h"
#include "tests/bench/stopwatch.h"
#include "tests/eval/timing.h"

namespace haptics::bench {
namespace {

/// Timed one by one for the percentiles, beside the mean of an unbroken run.
constexpr int kSingleTicks = 20'000;
constexpr int kColdTicks = 300;

void tickHot(benchmark::State& state, const Trajectory& trajectory, std::uint32_t segments) {
  Replay replay(trajectory.make(segments));
  for (auto _ : state) benchmark::DoNotOptimize(replay.tick());
  Stopwatch stopwatch;
  for (int i = 0; i < kSingleTicks; ++i) stopwatch.time([&] { benchmark::DoNotOptimize(replay.tick()); });
  stopwatch.report(state);
  state.counters["surfaces"] = static_cast<double>(replay.state().surfaces().size());
}

void tickCold(benchmark::State& state, const Trajectory& trajectory, std::uint32_t segments) {
  Replay replay(trajectory.make(segments));
  Stopwatch stopwatch;
  for (auto _ : state) {
    eval::sweepCaches();
    state.SetIterationTime(1e-9 * stopwatch.time([&] { benchmark::DoNotOptimize(replay.tick()); }));
  }
  stopwatch.report(state);
}

void searchAlone(benchmark::State& state, const Trajectory& trajectory, std::uint32_t segments) {
  Search search(trajectory.make(segments));
  for (auto _ : state) benchmark::DoNotOptimize(search.tick());
}

/// The same with what surface properties add.
void wholeStep(benchmark::State& state, const Trajectory& trajectory, std::uint32_t segments,
               const SurfaceCase& surface) {
  StepReplay replay(trajectory.make(segments), segments, surface);
  for (auto _ : state) benchmark::DoNotOptimize(replay.tick());
  Stopwatch stopwatch;
  for (int i = 0; i < kSingleTicks; ++i) stopwatch.time([&] { benchmark::DoNotOptimize(replay.tick()); });
  stopwatch.report(state);
}

}  // namespace

void registerContact(std::span<const std::uint32_t> sizes) {
  const auto cold = [](const Trajectory& t, std::uint32_t n) {
    benchmark::RegisterBenchmark(nameOf("contact_tick/cold", t, n).c_str(), tickCold, t, n)
        ->UseManualTime()
        ->Iterations(kColdTicks);
  };
  cold(kRubbing, kCoarsest);  // what the others are compared with
  for (const std::uint32_t n : sizes) {
    for (const Trajectory& t : {kRubbing, kSlide, kFreeSpace, kSecondBodyNear, kLineContact}) {
      benchmark::RegisterBenchmark(nameOf("contact_tick/hot", t, n).c_str(), tickHot, t, n);
      cold(t, n);
    }
    for (const Trajectory& t : {kRubbing, kSlide}) {
      benchmark::RegisterBenchmark(nameOf("search/hot", t, n).c_str(), searchAlone, t, n);
      for (const SurfaceCase& surface :
           {kPlain, kShading, kFriction, kGrating, kNoise, kAllFeatures, kSoft, kSoftWithAll}) {
        const std::string what = std::string("haptic_step/hot/") + surface.name;
        benchmark::RegisterBenchmark(nameOf(what.c_str(), t, n).c_str(), wholeStep, t, n, surface);
      }
    }
  }
}

}  // namespace haptics::bench

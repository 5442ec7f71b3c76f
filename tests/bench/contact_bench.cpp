#include <benchmark/benchmark.h>

#include <string>

#include "haptic_server/servo/haptic_step.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenes.h"
#include "tests/bench/stopwatch.h"

namespace haptics::bench {
namespace {

/// Timed one by one for the percentiles, beside the mean of an unbroken run.
constexpr int kSingleTicks = 20'000;
constexpr int kColdTicks = 300;

std::string nameOf(const char* what, const Trajectory& trajectory, std::uint32_t segments) {
  return std::string(what) + "/" + trajectory.name + "/triangles:" + std::to_string(triangleCount(segments));
}

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
    sweepCaches();
    state.SetIterationTime(1e-9 * stopwatch.time([&] { benchmark::DoNotOptimize(replay.tick()); }));
  }
  stopwatch.report(state);
}

void searchAlone(benchmark::State& state, const Trajectory& trajectory, std::uint32_t segments) {
  Search search(trajectory.make(segments));
  for (auto _ : state) benchmark::DoNotOptimize(search.tick());
}

/// From the device's position to the force (paper 3.2), with one object.
void wholeStep(benchmark::State& state, const Trajectory& trajectory, std::uint32_t segments) {
  const Scene path = trajectory.make(segments);
  ServoScene scene;
  scene.revision = 1;
  scene.objects.push_back({1, sphere(segments), {}, 1000, 0.5, false});
  const StepConfig config;
  HapticState servo(config);
  (void)adoptScene(scene, servo, 0);  // nothing is in contact
  StepInput input;
  const auto step = [&](Vec3 hip) {
    ++input.tick;
    input.device = {hip, DeviceState::kReady};
    return hapticStep(scene, servo, config, input);
  };
  for (const Vec3 hip : path.approach) static_cast<void>(step(hip));
  std::size_t next = 0;
  const auto stepOn = [&] {
    benchmark::DoNotOptimize(step(path.path[next]));
    if (++next == path.path.size()) next = 0;
  };
  for (auto _ : state) stepOn();
  Stopwatch stopwatch;
  for (int i = 0; i < kSingleTicks; ++i) stopwatch.time(stepOn);
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
      benchmark::RegisterBenchmark(nameOf("haptic_step/hot", t, n).c_str(), wholeStep, t, n);
    }
  }
}

}  // namespace haptics::bench

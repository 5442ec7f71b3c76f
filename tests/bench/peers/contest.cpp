#include "tests/bench/peers/contest.h"

#include <benchmark/benchmark.h>

#include <cmath>

#include "tests/bench/stopwatch.h"

namespace haptics::bench {
namespace {

constexpr int kRounds = 15;  // an odd number, for the median

void race(benchmark::State& state, const Course& course) {
  const std::size_t count = course.contestants.size();
  std::vector<std::vector<double>> lap_ns(count);
  std::vector<std::vector<double>> afterOthers_ns(count);
  std::vector<std::vector<double>> ratio(count);
  const auto time_ns = [&](const Contestant& contestant) {
    const Clock::time_point begin = Clock::now();
    benchmark::DoNotOptimize(contestant.lap());
    const std::chrono::duration<double, std::nano> taken = Clock::now() - begin;
    return taken.count() / static_cast<double>(course.questions);
  };
  for (auto _ : state) {
    for (std::size_t i = 0; i < count; ++i) {
      afterOthers_ns[i].push_back(time_ns(course.contestants[i]));
      lap_ns[i].push_back(time_ns(course.contestants[i]));
      ratio[i].push_back(lap_ns[i].back() / lap_ns[0].back());
    }
  }
  const std::string against = "_over_" + course.contestants.front().name;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string& name = course.contestants[i].name;
    state.counters[name + "_ns"] = percentile(lap_ns[i], 0.5);
    state.counters[name + "_after_others_ns"] = percentile(afterOthers_ns[i], 0.5);
    if (i > 0) state.counters[name + against] = percentile(ratio[i], 0.5);
  }
}

/// The warm-up lap, and that all mean the same by the question.
std::string disagreement(const Course& course) {
  const double wanted = course.contestants.front().lap();
  for (const Contestant& contestant : course.contestants) {
    const double answer = contestant.lap();
    if (!(std::abs(answer - wanted) <= course.tolerance * std::abs(wanted))) {
      return contestant.name + " answers " + std::to_string(answer) + " instead of " + std::to_string(wanted);
    }
  }
  return {};
}

}  // namespace

void registerContest(const std::string& name, std::function<Course()> make) {
  const auto run = [make = std::move(make)](benchmark::State& state) {
    const Course course = make();
    if (const std::string wrong = disagreement(course); !wrong.empty()) return state.SkipWithError(wrong.c_str());
    race(state, course);
  };
  benchmark::RegisterBenchmark(name.c_str(), run)->Iterations(kRounds)->UseRealTime();
}

}  // namespace haptics::bench

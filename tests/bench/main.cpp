// haptic_bench: what a tick and a build cost. Options are Google Benchmark's: --benchmark_filter=REGEX,
// --benchmark_format=json, ...

#include <benchmark/benchmark.h>

#include "tests/bench/benches.h"

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  haptics::bench::registerContact();
  haptics::bench::registerBuild();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}

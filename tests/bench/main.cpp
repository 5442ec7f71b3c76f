// haptic_bench: what a tick and a build cost, and what peers need for the same. Options are Google Benchmark's:
// --benchmark_filter=REGEX, --benchmark_format=json, ...

#include <benchmark/benchmark.h>

#include <cstring>
#include <iostream>

#include "common/log/log.h"
#include "tests/bench/benches.h"
#include "tests/bench/peers/peers.h"
#include "tests/bench/scenes.h"

namespace {

constexpr const char* kLargest = "--with-10m";

/// Takes the option out of the arguments.
bool take(int& argc, char** argv, const char* option) {
  char** const end = argv + argc;
  char** const found = std::find_if(argv + 1, end, [=](const char* given) { return std::strcmp(given, option) == 0; });
  if (found == end) return false;
  std::copy(found + 1, end, found);
  --argc;
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  namespace bench = haptics::bench;
  constexpr int kWithStructure = 4;
  if (argc == kWithStructure && std::strcmp(argv[1], bench::kStructure) == 0) {
    return bench::runStructure(argv[2], argv[3]);
  }
  haptics::logTo(stderr);  // the figures are on the standard output
  const bool largest = take(argc, argv, kLargest);
  benchmark::Initialize(&argc, argv, [] { std::cout << "haptic_bench [" << kLargest << "]\n"; });
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::AddCustomContext("embree", bench::Embree::version());
  benchmark::AddCustomContext("cgal", bench::Cgal::version());
  const auto sizes = std::span(bench::kSegments).first(bench::kSegments.size() - (largest ? 0 : 1));
  bench::registerContact(sizes);
  bench::registerPhases(sizes);
  bench::registerPeers(sizes);
  bench::registerServo(sizes);
  bench::registerEffects();
  bench::registerTools();
  bench::registerBuild(sizes);
  bench::registerProtocol();
  bench::registerStructures(sizes);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}

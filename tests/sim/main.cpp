#include <chrono>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/command_line/command_line.h"
#include "tests/sim/simulation.h"

// haptics_sim: the production session, sequencer and mirror code in virtual time, one world for each seed.
namespace haptics::sim {
namespace {

struct Options {
  std::string seeds = "1..100";
  std::string mutant;
  std::string json;
  bool allMutants = false;
  bool verbose = false;
};

struct SeedRange {
  std::uint64_t from = 1, to = 1;
};

struct Tally {
  std::uint64_t seeds = 0;
  std::vector<std::uint64_t> failed;
  double virtual_s = 0;
  Oracle::Counts counts;

  void add(std::uint64_t seed, const Simulation& world) {
    ++seeds;
    if (!world.oracle().violations().empty()) failed.push_back(seed);
    virtual_s += world.lasted_s();
    counts += world.oracle().counts();
  }
};

nlohmann::json toJson(const Tally& tally, double wall_s) {
  const Oracle::Counts& c = tally.counts;
  return {{"seeds", tally.seeds},
          {"failed_seeds", tally.failed},
          {"virtual_s", tally.virtual_s},
          {"wall_s", wall_s},
          {"edits", c.edits},
          {"accepted", c.accepted},
          {"commits", c.commits},
          {"increments", c.increments},
          {"conflicts", c.conflicts},
          {"refused", c.refused},
          {"live", c.live},
          {"lost_with_state", c.lostWithState},
          {"server_starts", c.starts},
          {"state_resets", c.stateResets},
          {"corruptions", c.corruptions},
          {"resyncs", c.resyncs}};
}

SeedRange parseSeeds(const std::string& text) {
  const auto dots = text.find("..");
  if (dots == std::string::npos) return {std::stoull(text), std::stoull(text)};
  return {std::stoull(text.substr(0, dots)), std::stoull(text.substr(dots + 2))};
}

/// The end of what happened, from a second run of the same seed.
void explain(std::uint64_t seed, Mutant mutant) {
  Simulation again(seed, mutant, EventLog::Mode::kLast);
  again.run();
  std::printf("\nseed %llu fails:\n", static_cast<unsigned long long>(seed));
  for (const std::string& violation : again.oracle().violations()) std::printf("  %s\n", violation.c_str());
  std::printf("up to the first of them (haptics_sim --seeds %llu --verbose shows everything):\n",
              static_cast<unsigned long long>(seed));
  for (const std::string& line : again.log().last()) std::printf("  %s\n", line.c_str());
}

int trySeeds(const Options& options, SeedRange range, Mutant mutant) {
  const auto start = std::chrono::steady_clock::now();
  Tally tally;
  constexpr std::uint64_t kProgressEvery = 100;
  for (std::uint64_t seed = range.from; seed <= range.to; ++seed) {
    Simulation world(seed, mutant, options.verbose ? EventLog::Mode::kPrint : EventLog::Mode::kOff);
    world.run();
    tally.add(seed, world);
    if (!world.oracle().violations().empty() && !options.verbose && tally.failed.size() == 1) explain(seed, mutant);
    if (tally.seeds % kProgressEvery == 0) {
      std::fprintf(stderr, "%llu seeds, %zu failed\n", static_cast<unsigned long long>(tally.seeds),
                   tally.failed.size());
    }
  }
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const std::string summary = toJson(tally, wall_s).dump();
  std::printf("%s\n", summary.c_str());
  if (!options.json.empty()) std::ofstream(options.json) << summary << '\n';
  return tally.failed.empty() ? 0 : 1;
}

/// Each mutant must be caught by one of the seeds.
int tryMutants(SeedRange range) {
  int escaped = 0;
  for (const MutantInfo& info : allMutants()) {
    std::string how;
    std::uint64_t seed = range.from;
    for (; seed <= range.to && how.empty(); ++seed) {
      Simulation world(seed, info.mutant, EventLog::Mode::kOff);
      world.run();
      if (!world.oracle().violations().empty()) how = world.oracle().violations().front();
    }
    escaped += how.empty() ? 1 : 0;
    if (how.empty()) {
      std::printf("%-28s NOT CAUGHT   %s\n", info.name.data(), info.what.data());
    } else {
      std::printf("%-28s caught by seed %llu: %s\n", info.name.data(), static_cast<unsigned long long>(seed - 1),
                  how.c_str());
    }
  }
  return escaped == 0 ? 0 : 1;
}

}  // namespace
}  // namespace haptics::sim

int main(int argc, char** argv) {
  using namespace haptics::sim;
  Options options;
  haptics::CommandLine app("Runs client and server code against each other in virtual time, one world for each seed");
  app.option("--seeds,--seed", options.seeds, "FROM..TO, or one").showDefault();
  app.option("--mutant", options.mutant, "Break the protocol in this way");
  app.flag("--all-mutants", options.allMutants, "Each in turn; fails unless every one is caught");
  app.flag("--verbose", options.verbose, "Print everything that happens");
  app.option("--json", options.json, "Write the summary here too");
  if (const auto code = app.parse(argc, argv)) return *code;

  const auto range = parseSeeds(options.seeds);
  if (options.allMutants) return tryMutants(range);
  const auto mutant = options.mutant.empty() ? Mutant::kNone : mutantNamed(options.mutant);
  if (!mutant) {
    std::fprintf(stderr, "there is no mutant \"%s\"; there are:\n", options.mutant.c_str());
    for (const MutantInfo& info : allMutants())
      std::fprintf(stderr, "  %-28s %s\n", info.name.data(), info.what.data());
    return 2;
  }
  return trySeeds(options, range, *mutant);
}

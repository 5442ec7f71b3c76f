#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "tests/eval/sweep/sweep.h"

namespace haptics::eval {

/// Instructions that a tick may take are those of this time at 1 kHz on the machine that counts them; in proportion at other
/// rates.
inline constexpr double kWorstTick_us = 250;
/// Of such ticks 5,700 to 11,700 were executed in a microsecond on the machine of tests/bench/results: counted, and the
/// shortest of five runs timed.
inline constexpr double kInstructionsPer_us = 6000;

struct WorstOptions {
  std::uint64_t seed = 1;
  double seconds = 60;  ///< Of all hunts, one after another; what comes after them takes some more.
  double rate_Hz = 1000;
  std::string family;  ///< Only this one; empty: all.
  bool withoutAllowance = false;
  std::filesystem::path kept;  ///< A worst.json of an earlier hunt: its ticks again, no hunt.
  std::filesystem::path out = ".";
};

/// Hunts for the slowest tick: scenes and motions of every family, changed towards more work, the worst of each counted in
/// instructions and timed. Its finish() writes DIR/worst.json with the genes of the worst ones and, without `kept`,
/// worst.png and worst.svg: how many ticks take longer than how long, ours and the baselines. It says whether no tick took
/// more than kWorstTick_us allows. While it lives, Ctrl-C ends the hunts and keeps what they found.
/// Throws std::runtime_error naming what cannot be read, written or drawn; std::invalid_argument where there is no such
/// family.
[[nodiscard]] std::unique_ptr<Sweep> makeWorstSweep(const WorstOptions& options);

/// Instructions of the worst tick of all that an earlier hunt kept, at 1 kHz: made and counted again.
/// Throws std::runtime_error naming the file, where it holds none.
[[nodiscard]] double worstKeptInstructions(const std::filesystem::path& kept);

}  // namespace haptics::eval

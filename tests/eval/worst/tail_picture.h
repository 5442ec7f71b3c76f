#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/eval/statistics.h"
#include "tests/eval/worst/play.h"

namespace haptics::eval {

/// What part of the ticks takes longer than so many microseconds.
struct Tail {
  std::string name;                                 ///< Of the family, or of the method.
  std::string method;                               ///< "ours", or "baseline".
  std::vector<std::pair<double, double>> survival;  ///< us, part; of ticks that there were.
};

/// At quantiles that are even on a logarithmic scale; none where there are no durations.
[[nodiscard]] std::vector<std::pair<double, double>> survivalOf(Statistics& durations_ns);

/// The baselines' ticks in the scenes and motions that were the worst for ours, each method's together.
[[nodiscard]] std::vector<Tail> baselineTails(const std::vector<std::pair<const Family*, Genome>>& worst, int ticks);

/// Draws FOLDER/worst.png and worst.svg: which part of the ticks takes longer than how long. `limit_us` is marked. Throws
/// std::runtime_error.
void drawTails(const std::vector<Tail>& tails, double limit_us, const std::filesystem::path& folder);

}  // namespace haptics::eval

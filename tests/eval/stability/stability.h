#pragma once

#include <filesystem>
#include <memory>

#include "tests/eval/sweep/sweep.h"

namespace haptics::eval {

struct StabilityOptions {
  bool shortRun = false;
  bool full = false;
  std::filesystem::path from;  ///< stability.json of an earlier run, to be drawn again; empty: measures.
  std::filesystem::path out = ".";
};

/// Its finish() writes stability.json, and stability.png and .svg unless the run is short, and says whether every record is
/// within its limit.
[[nodiscard]] std::unique_ptr<Sweep> makeStabilitySweep(const StabilityOptions& options);
/// The pictures of an earlier run.
void redrawStability(const StabilityOptions& options);

}  // namespace haptics::eval

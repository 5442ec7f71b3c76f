#pragma once

#include <filesystem>

namespace haptics::eval {

struct StabilityOptions {
  bool shortRun = false;
  bool full = false;
  std::filesystem::path from;  ///< stability.json of an earlier run, to be drawn again; empty: measures.
  std::filesystem::path out = ".";
};

/// Writes stability.json, and stability.png and .svg unless the run is short. Returns whether every record is within its
/// limit.
[[nodiscard]] bool runStability(const StabilityOptions& options);

}  // namespace haptics::eval

#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "tests/eval/sweep/sweep.h"

namespace haptics::eval {

struct WalkOptions {
  std::uint64_t seed = 1;
  std::int64_t ticks = 10'000'000;  ///< Over all scenes together.
  std::string method = "ours";      ///< One of methods().
  std::string scene;                ///< Only this one; empty for all.
  /// Folder that deploy/models/fetch_and_report filled. Empty: the generated shapes, and models that are installed.
  std::filesystem::path models;
};

/// A HIP that wanders over generated and real shapes at up to 2 m/s, judged in each tick by code that shares nothing
/// with the method: is the IHIP inside a body, is it held by nothing, is it let go where a path-continuous reference
/// holds, is it elsewhere than the reference. Among boxes that close on the IHIP, and on closed meshes that pass through
/// themselves, there is no reference: there the IHIP is to be inside of none for more than a tick, by winding number. Its
/// finish() writes DIR/walk.json and DIR/walk_episodes.csv, and says whether every scene passed: no wrong tick, and the
/// reference left no more often than twice as often as it leaves itself when its steps are made eight times finer, and 5
/// times in 10^6 ticks.
/// Throws std::runtime_error when the method is not there, or the file of a model that `models` or `scene` asks for.
[[nodiscard]] std::unique_ptr<Sweep> makeWalkSweep(const WalkOptions& options, const std::filesystem::path& out);

}  // namespace haptics::eval

#pragma once

#include <filesystem>

#include "tests/eval/fuzz/edit_judge.h"

namespace haptics::eval {

/// Leaves out windows, scenes, ticks, objects and features as long as what is left fails in the same way.
[[nodiscard]] EditRun reduced(EditRun run, const EditFinding& finding);

/// Writes edits.txt (what the scenes are and when they come, as its first lines explain), hip.csv (for how many ticks the HIP is where) and
/// mesh<i>.obj. Nothing is rounded. Throws std::runtime_error naming the file that cannot be written.
void writeRun(const EditRun& run, const std::filesystem::path& folder);

[[nodiscard]] bool isRun(const std::filesystem::path& folder);
/// What writeRun() wrote. Throws std::runtime_error naming the file and the line that is wrong.
[[nodiscard]] EditRun readRun(const std::filesystem::path& folder);

}  // namespace haptics::eval

#pragma once

#include <filesystem>

namespace haptics::eval {

struct JudgeOptions {
  std::filesystem::path folder;  ///< Of one scene, or of such folders.
  std::filesystem::path out = ".";
};

/// Judges what `failures --export` wrote, or somebody else in its place (README.md), by the files alone: the scene is led
/// again, and each answer is that of forces.csv. Prints verdicts, writes DIR/judge.json. @return Whether each is that of
/// verdict.json, or passes where there is none. Throws std::runtime_error naming the file, and the row, that is wrong.
[[nodiscard]] bool runJudge(const JudgeOptions& options);

}  // namespace haptics::eval

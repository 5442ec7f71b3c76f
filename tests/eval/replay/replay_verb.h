#pragma once

#include <filesystem>
#include <string>

namespace haptics::eval {

struct ReplayOptions {
  std::filesystem::path recording;
  std::string telemetry;  ///< File for what was felt in each tick; empty: none.
};

/// Runs the step over a recording of haptic_server and says whether every force is the recorded one, bit for bit, or where
/// the first one differs and by how much; writes DIR/replay.json.
/// @return Whether all are, and the recording was readable to its end.
/// Throws std::runtime_error when a file cannot be read or written.
[[nodiscard]] bool runReplay(const ReplayOptions& options, const std::filesystem::path& out);

}  // namespace haptics::eval

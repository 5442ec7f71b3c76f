#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/hash/content_hash.h"

namespace haptics::stress {

/// How old a sample was when a watcher heard it, in bins; the last one holds all that were older.
inline constexpr double kAgeBin_ms = 0.1;
inline constexpr std::size_t kAgeBins = 50'000;

struct WatchersOptions {
  std::string nats, session;
  int count = 1;
  int viewers = 0;                ///< Of them, those that hold all assets too, as graphics_client does.
  std::filesystem::path summary;  ///< What they saw, as JSON, at SIGTERM.
};

/// Many clients in one process, each with a connection of its own, that watch a published session and check every root. It
/// says on standard output, as allHold() has it, whenever all hold another scene.
void runWatchers(const WatchersOptions& options);

[[nodiscard]] std::string allHold(std::uint64_t revision, const ContentHash& root);

}  // namespace haptics::stress

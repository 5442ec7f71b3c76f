#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "common/error/error.h"

namespace haptics {

/// How a program is started.
struct SpawnOptions {
  std::vector<std::string> arguments = {};
  std::vector<int> descriptors;  ///< Its 0, 1, 2 and so on, and no others; -1: /dev/null.
  bool ownSession = false;
  std::vector<int> blockedSignals = {};  ///< All signals have their default effect.
};

/// Spawned, not forked, so that the pages of a process with locked memory are not copied.
/// @return The process; or why the program does not start.
[[nodiscard]] Result<pid_t> spawn(const std::filesystem::path& program, const SpawnOptions& options);

}  // namespace haptics

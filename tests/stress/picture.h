#pragma once

#include <filesystem>

#include "tests/stress/run.h"

namespace haptics::stress {

/// DIR/stress.png and .svg: telemetry age, revision lag and the servo's wake-ups over time. Throws std::runtime_error.
void drawPicture(const RunResult& result, const std::filesystem::path& folder);

}  // namespace haptics::stress

#pragma once

#include <filesystem>
#include <vector>

#include "tests/eval/report.h"

namespace haptics::eval {

/// Draws the Z-width of every device by method with the boundaries of the literature over it: stability.png and .svg in
/// the folder. Throws std::runtime_error where it cannot draw.
void drawStability(const std::vector<Record>& records, const std::filesystem::path& folder);

}  // namespace haptics::eval

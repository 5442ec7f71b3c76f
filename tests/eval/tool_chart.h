#pragma once

#include <filesystem>

namespace haptics::eval {

/// Time of a tick against the number of a tool's points: ours, a point shell over a distance field, and one point of CHAI3D
/// as often as there are points. Writes DIR/tool_points.csv, .png and .svg.
/// @param bench  What haptic_bench --benchmark_filter='tool_tick|field_tick' --benchmark_out=FILE wrote.
/// Throws std::runtime_error naming what cannot be read, written or drawn.
void drawToolChart(const std::filesystem::path& bench, const std::filesystem::path& out);

}  // namespace haptics::eval

#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "tests/eval/chart_points.h"

namespace haptics::eval {

using Outcomes = std::map<std::string, Outcome>;  ///< By method.

/// What the chart shows.
struct ChartData {
  std::vector<ChartPoint> points;
  Outcomes outcomes;
  double worstTick_instructions = 0;  ///< Of ours, in scenes found for it; 0 where none were given.
};

/// CSV, a line for each point. Throws std::runtime_error naming the file when it cannot be written.
void writeChartTable(const std::filesystem::path& file, const ChartData& data);

/// What writeChartTable() wrote. Throws std::runtime_error naming file and line when it cannot be read.
[[nodiscard]] ChartData readChartTable(const std::filesystem::path& file);

}  // namespace haptics::eval

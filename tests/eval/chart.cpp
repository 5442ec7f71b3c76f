#include "tests/eval/chart.h"

#include <algorithm>
#include <cstdio>
#include <sstream>
#include <stdexcept>

#include "tests/eval/chart_table.h"
#include "tests/eval/figure/figure.h"
#include "tests/eval/report.h"
#include "tests/eval/worst/worst.h"

namespace haptics::eval {
namespace {

/// "passes all 12 failure scenes", "fails 2 of 12: S4 S12", "fails 10 of 12: all but S5 S12".
std::string outcomeText(const Outcome& outcome) {
  std::ostringstream text;
  const std::size_t all = outcome.passed.size() + outcome.failed.size();
  if (outcome.failed.empty()) {
    text << "passes all " << all << " failure scenes";
    return text.str();
  }
  const bool most = outcome.failed.size() > outcome.passed.size();
  text << "fails " << outcome.failed.size() << " of " << all << (most ? ": all but" : ":");
  for (const std::string_view scene : most ? outcome.passed : outcome.failed) text << ' ' << scene;
  return text.str();
}

/// In place of what the data have of the same methods.
void measure(const ChartOptions& options, ChartData& data) {
  const std::span<const Method> chosen =
      options.method.empty() ? chartMethods() : std::span(&findMethod(options.method, chartMethods()), 1);
  for (const Method& method : chosen) {
    std::erase_if(data.points, [&](const ChartPoint& point) { return point.method == method.name; });
    data.outcomes[std::string(method.name)] = outcomeOf(method, options.seed);
  }
  for (ChartPoint& point : measureChartPoints(chosen, options.seed, options.finest))
    data.points.push_back(std::move(point));
  std::ranges::stable_sort(data.points, {}, &ChartPoint::triangles);
}

}  // namespace

void runChart(const ChartOptions& options) {
  ChartData data;
  if (!options.from.empty()) data = readChartTable(options.from);
  if (!options.kept.empty()) data.worstTick_instructions = worstKeptInstructions(options.kept);
  if (options.from.empty() || !options.method.empty()) measure(options, data);
  if (data.points.empty()) throw std::runtime_error("no method has a point in the chart");
  writeChartTable(options.out / "chart.csv", data);
  Record notes;
  Record fromOutside = Record::array();
  for (const auto& [method, outcome] : data.outcomes) {
    notes[method] = outcomeText(outcome);
    if (std::ranges::find(chartMethods(), method, &Method::name) == chartMethods().end()) fromOutside.push_back(method);
    std::printf("%-25s %s\n", method.c_str(), outcomeText(outcome).c_str());
  }
  std::fflush(stdout);
  drawFigure("chart",
             {{"table", (options.out / "chart.csv").string()},
              {"instructions_per_us", kInstructionsPer_us},
              {"notes", std::move(notes)},
              {"from_outside", std::move(fromOutside)}},
             options.out / "chart");
  std::printf("written to %s: chart.png, chart.svg, chart.csv\n", options.out.c_str());
}

}  // namespace haptics::eval

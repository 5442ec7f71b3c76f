#include "tests/eval/chart.h"

#include <cstdio>
#include <sstream>

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

}  // namespace

void runChart(const ChartOptions& options) {
  ChartData data;
  if (options.from.empty()) {
    if (!options.kept.empty()) data.worstTick_instructions = worstKeptInstructions(options.kept);
    data.points = measureChartPoints(options.seed, options.finest);
    for (const Method& method : chartMethods()) data.outcomes[method.name] = outcomeOf(method, options.seed);
  } else {
    data = readChartTable(options.from);
  }
  writeChartTable(options.out / "chart.csv", data);
  Record notes;
  for (const auto& [method, outcome] : data.outcomes) {
    notes[std::string(method)] = outcomeText(outcome);
    std::printf("%-25s %s\n", method.data(), outcomeText(outcome).c_str());
  }
  std::fflush(stdout);
  drawFigure("chart",
             {{"table", (options.out / "chart.csv").string()},
              {"instructions_per_us", kInstructionsPer_us},
              {"notes", std::move(notes)}},
             options.out / "chart");
  std::printf("written to %s: chart.png, chart.svg, chart.csv\n", options.out.c_str());
}

}  // namespace haptics::eval

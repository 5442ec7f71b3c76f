#include "tests/eval/chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <sstream>
#include <stdexcept>

#include "tests/eval/chart_table.h"
#include "tests/eval/figure/figure.h"
#include "tests/eval/figure/virtual_display.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/scenes/scenes.h"
#include "tests/eval/worst/worst.h"

namespace haptics::eval {
namespace {

/// Okabe and Ito's colours, which colour-blind people tell apart. What is not named is in the table only: a variant that
/// would be drawn over another.
struct MethodLook {
  std::string_view method;
  const char* name;
  Colour colour;
};
constexpr std::array kLooks{
    MethodLook{kOurs, "this runtime", {0.835, 0.369, 0.0}},
    MethodLook{"ours_shaded", "this runtime, force shading", {0.60, 0.07, 0.12}},
    MethodLook{"ours_without_substeps", "this runtime, no substeps", {0.30, 0.16, 0.06}},
    MethodLook{"ours_float", "this runtime, search in float", {0.902, 0.624, 0.0}},
    MethodLook{"god_object", "god-object", {0.0, 0.447, 0.698}},
    MethodLook{"finite_proxy_1mm", "finite proxy, 1 mm", {0.337, 0.706, 0.914}},
    MethodLook{"global_closest", "closest point, penalty", {0.0, 0.62, 0.451}},
    MethodLook{"intermediate_plane_100Hz", "tangent plane, 100 Hz", {0.8, 0.475, 0.655}},
    MethodLook{"intermediate_plane_30Hz", "tangent plane, 30 Hz", {0.52, 0.30, 0.50}},
    MethodLook{"pseudocode_open", "paper as printed, open", {0.45, 0.45, 0.45}},
    MethodLook{"pseudocode_closed", "paper as printed, closed", {0.0, 0.0, 0.0}},
};

Marker markerOf(const Outcome& outcome, const ClosedLoopRest& rest) {
  return !outcome.failed.empty() ? Marker::kCross : rest.steady() ? Marker::kDisc : Marker::kDiamond;
}

std::string sizeText(int triangles) {
  if (triangles < 1000) return std::to_string(triangles);
  const bool millions = triangles >= 1'000'000;
  return std::to_string(std::lround(triangles / (millions ? 1e6 : 1e3))) + (millions ? " M" : " k");
}

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

/// "worst tick, 210 us".
std::string timeText(double ns) { return "worst tick, " + std::to_string(std::lround(ns / 1e3)) + " us"; }
/// "worst tick, 1.26 M".
std::string countText(double instructions) {
  char text[40];
  std::snprintf(text, sizeof text, "worst tick, %.2f M", instructions / 1e6);
  return text;
}

/// Of ours; none where nobody looked for it.
std::optional<UprightMark> markAt(double x, const std::string& label) {
  if (x == 0) return std::nullopt;
  return UprightMark{x, 0, label};
}

using Value = std::function<double(const ChartPoint&)>;

struct Axis {
  const char* label;
  Value value;
  Decades decades;
};

/// Holds the points and the `values`, but is never beyond `most`: what lies farther out is drawn on the rim.
Axis axis(const char* label, Value value, const std::vector<ChartPoint>& points, Decades most,
          std::vector<double> values = {}) {
  for (const ChartPoint& p : points) values.push_back(value(p));
  const Decades all = decadesOf(values);
  return {label, std::move(value), {std::max(all.low, most.low), std::min(all.high, most.high)}};
}

Panel panelOf(const std::string& title, const Axis& x, const Axis& y, const ChartData& data, bool labelled) {
  Panel panel{title, x.label, y.label, x.decades, y.decades, {}, {}};
  for (std::size_t i = 0; i < kLooks.size(); ++i) {
    Curve curve{i, {}};
    for (const ChartPoint& p : data.points) {
      if (p.method != kLooks[i].method || !(x.value(p) > 0)) continue;
      const bool named = labelled && i == 0;
      curve.points.push_back(
          {x.value(p), y.value(p), named ? sizeText(p.triangles) : "", markerOf(data.outcomes.at(p.method), p.rest)});
    }
    panel.curves.push_back(std::move(curve));
  }
  return panel;
}

Figure figureOf(const ChartData& data) {
  const std::vector<ChartPoint>& points = data.points;
  Figure figure;
  figure.title = "Speed and accuracy of point-based haptic rendering";
  figure.caption = {
      "Sphere, torus, cylinder, cube, L-shape and sine grating, stroked 2 mm deep at 0.1 m/s, 1 kHz, "
      "k = 1000 N/m. One point for each mesh resolution, numbers: triangles."};
  figure.columns = 3;
  constexpr double kNoticeable = 1;
  constexpr Decades kTimes{0, 7};
  const double worst = data.worstTick_instructions;
  const double worst_ns = worst / kInstructionsPer_us * 1e3;
  const std::array<std::optional<UprightMark>, 3> marks{markAt(worst_ns, timeText(worst_ns)), std::nullopt,
                                                        markAt(worst, countText(worst))};
  const std::array xs{
      axis("contact tick, ns (median)", [](const ChartPoint& p) { return p.price.hot_ns; }, points, kTimes, {worst_ns}),
      axis(
          "contact tick, ns (median)", [](const ChartPoint& p) { return p.price.cold_ns; }, points, kTimes),
      axis("instructions per tick", [](const ChartPoint& p) { return p.price.instructions; }, points, kTimes, {worst})};
  const std::array ys{
      axis("force error, 1: just noticeable", [](const ChartPoint& p) { return p.epsilon; }, points, {-2, 3},
           {kNoticeable / 2}),
      axis("false force above 100 Hz, N rms", [](const ChartPoint& p) { return p.above100Hz_rms_N; }, points, {-3, 1})};
  const std::array titles{"Caches hot", "Caches cold", "Instructions"};
  for (const Axis& y : ys) {
    for (std::size_t i = 0; i < xs.size(); ++i) {
      figure.panels.push_back(panelOf(titles[i], xs[i], y, data, i == 0 && &y == &ys.front()));
      figure.panels.back().mark = marks[i];
      if (&y == &ys.front()) figure.panels.back().threshold = {kNoticeable, "too small to notice"};
    }
  }
  figure.legendTitle = "Method";
  for (const MethodLook& look : kLooks) {
    const auto found = data.outcomes.find(look.method);
    if (found == data.outcomes.end()) throw std::runtime_error("the table has no " + std::string(look.method));
    const Outcome& outcome = found->second;
    figure.styles.push_back({look.name, outcomeText(outcome), look.colour,
                             outcome.failed.empty() ? Marker::kDisc : Marker::kCross, look.method == kOurs});
  }
  figure.legendNotes = {"Disc: passes every scripted failure scene.",
                        "Diamond: so it does, but rings: under 1 N",
                        "the HIP moves over 2 encoder steps.",
                        "Cross: fails some; the scenes are those of",
                        "haptic_eval failures.",
                        "Upright: this runtime's worst tick of what",
                        "hunts found, at " + std::to_string(std::lround(kInstructionsPer_us)) + " instructions a us.",
                        "No substeps, search in float: one over the",
                        "other, by the guarded path in every tick.",
                        "Dashed: what a hand with vision notices,",
                        "7 % of a force (Pang et al. 1991) or 0.05 N,",
                        "18.4 deg (Barbagli et al. 2006)."};
  return figure;
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
  const auto display = orThrow(VirtualDisplay::ensure());
  orThrow(drawFigure(figureOf(data), options.out / "chart.png", options.out / "chart.svg"));
  for (const auto& [method, outcome] : data.outcomes) {
    std::printf("%-25s %s\n", method.data(), outcomeText(outcome).c_str());
  }
  std::printf("written to %s: chart.png, chart.svg, chart.csv\n", options.out.c_str());
}

}  // namespace haptics::eval

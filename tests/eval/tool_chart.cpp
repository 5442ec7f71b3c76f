#include "tests/eval/tool_chart.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "tests/eval/figure/figure.h"
#include "tests/eval/figure/virtual_display.h"
#include "tests/eval/or_throw.h"

namespace haptics::eval {
namespace {

/// One benchmark's figures.
struct ToolPoints {
  std::string method;  ///< tool_tick or field_tick.
  std::string motion;
  int points = 0, triangles = 0, cells = 0;
  double p50_us = 0, deepest_um = 0, touching = 0, build_s = 0, field_MB = 0;
};

/// Median of CHAI3D's finger proxy for one point on a sphere of 1M triangles, us: by default, and in its most accurate mode.
constexpr double kChai3d_us = 1.382, kChai3dBest_us = 3.436;

/// "1000_points": 1000.
int numberOf(const std::string& word) { return std::stoi(word.substr(0, word.find('_'))); }

std::vector<ToolPoints> readBench(const std::filesystem::path& file) {
  std::ifstream stream(file);
  const nlohmann::json all = nlohmann::json::parse(stream, nullptr, false);
  std::vector<ToolPoints> rows;
  if (!all.is_object() || !all.contains("benchmarks")) throw std::runtime_error(file.string() + ": no benchmarks");
  for (const auto& run : all["benchmarks"]) {
    std::istringstream name(run.at("name").get<std::string>());
    std::vector<std::string> words;
    for (std::string word; std::getline(name, word, '/');) words.push_back(word);
    if (words.size() < 5 || (words[0] != "tool_tick" && words[0] != "field_tick")) continue;
    ToolPoints row{words[0], words[2], numberOf(words[3]), numberOf(words[4])};
    if (words[0] == "field_tick") row.cells = numberOf(words.at(5));
    row.p50_us = run.at("p50_ns").get<double>() / 1e3;
    row.deepest_um = run.at("deepest_um").get<double>();
    row.touching = run.at("touching").get<double>();
    row.build_s = run.value("build_s", 0.0);
    row.field_MB = run.value("field_MB", 0.0);
    rows.push_back(row);
  }
  if (rows.empty()) throw std::runtime_error(file.string() + ": no tool_tick and no field_tick");
  return rows;
}

void writeTable(const std::filesystem::path& file, const std::vector<ToolPoints>& rows) {
  std::ofstream table(file);
  table << "method,motion,points,triangles,cells,tick_p50_us,deepest_um,touching,build_s,field_MB\n";
  for (const ToolPoints& r : rows) {
    char line[200];
    std::snprintf(line, sizeof line, "%s,%s,%d,%d,%d,%.3f,%.1f,%.1f,%.2f,%.1f\n", r.method.c_str(), r.motion.c_str(),
                  r.points, r.triangles, r.cells, r.p50_us, r.deepest_um, r.touching, r.build_s, r.field_MB);
    table << line;
  }
  if (!table.flush()) throw std::runtime_error(file.string() + " cannot be written");
}

/// Which of the rows a curve is.
struct Look {
  const char* method;
  int triangles, cells;
  Style style;
};

const std::array<Look, 4>& looks() {
  static const std::array<Look, 4> all{{
      {"tool_tick", 65'536, 0, {"this runtime, 65,536 triangles", "passes nothing", {0.902, 0.624, 0.0}}},
      {"tool_tick",
       1'048'576,
       0,
       {"this runtime, 1,048,576 triangles", "passes nothing", {0.835, 0.369, 0.0}, Marker::kDisc, true}},
      {"field_tick", 65'536, 128, {"distance field, 128 cells", "", {0.337, 0.706, 0.914}, Marker::kCross}},
      {"field_tick", 65'536, 256, {"distance field, 256 cells", "", {0.0, 0.447, 0.698}, Marker::kCross}},
  }};
  return all;
}

/// A line through one point's time.
Curve timesOnePoint(std::size_t style, double us) { return {style, {{1, us, ""}, {4000, 4000 * us, ""}}}; }

Panel panelOf(const std::string& motion, const std::vector<ToolPoints>& rows) {
  constexpr double kTick_us = 1000;
  Panel panel{motion, "points of the tool", "tick, us (median)", {0, 4}, {-1, 4}, {}, {}};
  for (std::size_t i = 0; i < looks().size(); ++i) {
    const Look& look = looks()[i];
    Curve curve{i, {}};
    for (const ToolPoints& r : rows) {
      if (r.method != look.method || r.motion != motion || r.triangles != look.triangles || r.cells != look.cells)
        continue;
      curve.points.push_back({static_cast<double>(r.points), r.p50_us, ""});
    }
    panel.curves.push_back(std::move(curve));
  }
  panel.curves.push_back(timesOnePoint(looks().size(), kChai3d_us));
  panel.curves.push_back(timesOnePoint(looks().size() + 1, kChai3dBest_us));
  panel.threshold = {kTick_us, "1 kHz"};
  return panel;
}

/// "sinks in by up to 0.57 mm; built in 3 s, 23 MB".
std::string faultOf(const Look& look, const std::vector<ToolPoints>& rows) {
  double deepest_um = 0, build_s = 0, field_MB = 0;
  for (const ToolPoints& r : rows) {
    if (r.method != look.method || r.triangles != look.triangles || r.cells != look.cells) continue;
    deepest_um = std::max(deepest_um, r.deepest_um);
    build_s = r.build_s;
    field_MB = r.field_MB;
  }
  char text[100];
  std::snprintf(text, sizeof text, "sinks in by up to %.1f mm; %.0f s, %.0f MB", deepest_um / 1e3, build_s, field_MB);
  return text;
}

Figure figureOf(const std::vector<ToolPoints>& rows) {
  Figure figure;
  figure.title = "What a tool's points cost";
  figure.caption = {
      "An ellipsoid pressed into a torus and turned at 1 kHz: with its end (blunt), or lying on the ring (flat).",
      "Crosses: a point shell of springs over a distance field that is built beforehand (McNeely et al. 1999, Barbic & "
      "James 2008).",
      "Cells are along the longest side, seconds and MB the field's; it passes what is thinner than a cell.",
      "Dashed: no tool, but the time of one point on 1M triangles as often as there are points."};
  figure.columns = 2;
  for (const char* motion : {"blunt", "flat"}) figure.panels.push_back(panelOf(motion, rows));
  figure.legendTitle = "Method";
  for (const Look& look : looks()) {
    Style style = look.style;
    if (look.cells > 0) style.note = faultOf(look, rows);
    figure.styles.push_back(style);
  }
  figure.styles.push_back({"CHAI3D, one point, times N", "no torque of a shape", {0.0, 0.62, 0.451}, Marker::kNone});
  figure.styles.push_back({"the same, most accurate mode", "", {0.45, 0.45, 0.45}, Marker::kNone});
  return figure;
}

}  // namespace

void drawToolChart(const std::filesystem::path& bench, const std::filesystem::path& out) {
  const std::vector<ToolPoints> rows = readBench(bench);
  writeTable(out / "tool_points.csv", rows);
  const auto display = orThrow(VirtualDisplay::ensure());
  orThrow(drawFigure(figureOf(rows), out / "tool_points.png", out / "tool_points.svg"));
  std::printf("written to %s: tool_points.png, tool_points.svg, tool_points.csv\n", out.c_str());
}

}  // namespace haptics::eval

#include "tests/eval/chart_table.h"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "tests/eval/adapters/outside_method.h"
#include "tests/eval/scenes/scenes.h"

namespace haptics::eval {
namespace {

constexpr std::string_view kHead =
    "method,triangles,hot_tick_p50_ns,cold_tick_p50_ns,instructions_per_tick,epsilon_p99_ratio,"
    "force_above_100Hz_rms_N,limit_cycle_um,limit_cycle_allowed_um,worst_tick_instructions,passed_scenes,failed_scenes";

/// "it has no limit_cycle_um".
std::string difference(const std::string& head) {
  std::istringstream names{std::string(kHead)};
  for (std::string name; std::getline(names, name, ',');) {
    if ((',' + head + ',').find(',' + name + ',') == std::string::npos) return "it has no " + name;
  }
  return "its columns are others";
}

using SceneNames = std::vector<std::string_view>;

SceneNames readScenes(std::istream& fields, char end) {
  std::string field;
  std::getline(fields, field, end);
  std::istringstream words(field);
  SceneNames names;
  for (std::string word; words >> word;) {
    const auto scene = std::ranges::find(kFailureScenes, word, &FailureScene::name);
    if (scene == kFailureScenes.end()) throw std::invalid_argument("there is no scene " + word);
    names.push_back(scene->name);
  }
  return names;
}

void writeScenes(std::ostream& file, const SceneNames& names) {
  for (const std::string_view scene : names) file << scene << ' ';
}

void readLine(const std::string& line, ChartData& data) {
  std::istringstream fields(line);
  std::string name;
  std::getline(fields, name, ',');
  if (!isMethodName(name)) throw std::invalid_argument("names no method");
  ChartPoint point{name, 0, 0, 0, {}, {}};
  double worstTick_instructions = 0;
  char comma = 0;
  fields >> point.triangles >> comma >> point.price.hot_ns >> comma >> point.price.cold_ns >> comma >>
      point.price.instructions >> comma >> point.epsilon >> comma >> point.above100Hz_rms_N >> comma >>
      point.rest.limitCycle_um >> comma >> point.rest.allowed_um >> comma >> worstTick_instructions >> comma;
  if (!fields) throw std::invalid_argument("is not what chart writes");
  Outcome outcome;
  outcome.passed = readScenes(fields, ',');
  outcome.failed = readScenes(fields, '\n');
  if (outcome.passed.empty() && outcome.failed.empty()) throw std::invalid_argument("names no scene that was run");
  data.points.push_back(point);
  if (name == kOurs) data.worstTick_instructions = worstTick_instructions;
  data.outcomes[name] = std::move(outcome);
}

}  // namespace

void writeChartTable(const std::filesystem::path& path, const ChartData& data) {
  std::ofstream file(path);
  file << kHead << '\n';
  for (const auto& [method, outcome] : data.outcomes) {
    for (const ChartPoint& p : data.points) {
      if (p.method != method) continue;
      file << p.method << ',' << p.triangles << ',' << p.price.hot_ns << ',' << p.price.cold_ns << ','
           << p.price.instructions << ',' << p.epsilon << ',' << p.above100Hz_rms_N << ',' << p.rest.limitCycle_um
           << ',' << p.rest.allowed_um << ',' << (method == kOurs ? data.worstTick_instructions : 0) << ',';
      writeScenes(file, outcome.passed);
      file << ',';
      writeScenes(file, outcome.failed);
      file << '\n';
    }
  }
  file.close();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

ChartData readChartTable(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line) || line != kHead)
    throw std::runtime_error(path.string() + ": is not a chart.csv of this version: " + difference(line) +
                             "; measure it anew");
  ChartData data;
  for (int number = 2; std::getline(file, line); ++number) {
    try {
      readLine(line, data);
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(path.string() + ':' + std::to_string(number) + ": " + error.what());
    }
  }
  if (data.points.empty()) throw std::runtime_error(path.string() + ": the table has no method");
  std::ranges::stable_sort(data.points, {}, &ChartPoint::triangles);
  return data;
}

}  // namespace haptics::eval

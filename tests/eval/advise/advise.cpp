#include "tests/eval/advise/advise.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iomanip>
#include <stdexcept>

#include "common/text/grouped.h"
#include "tests/eval/advise/advice.h"
#include "tests/eval/advise/independent_check.h"
#include "tests/eval/advise/scene_writer.h"
#include "tests/eval/advise/verdict.h"
#include "tests/eval/figure/figure.h"
#include "tests/eval/or_throw.h"

namespace haptics::eval {
namespace {

/// What the picture shows.
Record figureOf(const SceneAdvice& advice, const std::string& scene) {
  Record objects = Record::array(), notes = Record::array();
  for (const ObjectAdvice& o : advice.objects) {
    std::string note = "not judged: no hand gets there";
    if (o.judged()) {
      const std::string own = std::to_string(o.candidates.front().triangles) + " triangles, ";
      note = own + (o.verdict.use ? std::to_string(o.mesh().triangles) + " are enough" : "kept");
    }
    Record candidates = Record::array(), rates = Record::array();
    for (const Candidate& c : o.candidates)
      candidates.push_back({c.triangles, c.difference.epsilon_p99, c.hot_ns, c.memory_MB});
    for (const MaterialOption& option : o.options) {
      const auto rate = option.steadyFrom();
      if (option.damping_Ns_per_m != o.ownOption().damping_Ns_per_m) continue;
      rates.push_back({option.stiffness_N_per_m, rate ? kRates_Hz[*rate] : 0});
    }
    objects.push_back({{"name", o.name}, {"note", note}, {"candidates", candidates}, {"rates", rates}});
    std::string names;
    for (const SceneFeature& feature : o.features) names += feature.judged() ? "" : ' ' + feature.name;
    if (!names.empty()) notes.push_back(o.name + ", not judged:" + names);
  }
  if (advice.rate)
    notes.push_back("Lowest rate for all: " + std::to_string(std::lround(kRates_Hz[*advice.rate])) + " Hz");
  return {{"scene", std::filesystem::path(scene).filename().string()},
          {"objects", objects},
          {"rates_Hz", kRates_Hz},
          {"notes", notes}};
}

void writeCsv(const std::filesystem::path& path, const SceneAdvice& advice) {
  std::ofstream file(path);
  file << "object,triangles,advised,deviation_mm,epsilon_p99_ratio,epsilon_max_ratio,hot_tick_p50_ns,cold_tick_p50_ns,"
          "memory_MB,pass\n";
  for (const ObjectAdvice& o : advice.objects) {
    for (std::size_t i = 0; i < o.candidates.size(); ++i) {
      const Candidate& c = o.candidates[i];
      file << std::quoted(o.name, '"', '"') << ',' << c.triangles << ',' << (i == o.advised) << ',' << c.deviation_mm
           << ',' << c.difference.epsilon_p99 << ',' << c.difference.epsilon_max << ',' << c.hot_ns << ',' << c.cold_ns
           << ',' << c.memory_MB << ',' << c.good() << '\n';
    }
  }
  file.close();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

void writeObjectsCsv(const std::filesystem::path& path, const SceneAdvice& advice) {
  std::ofstream file(path);
  file << "object,verdict,not_judged,not_felt\n";
  if (advice.tool) {
    file << advice.tool->name << ',' << std::quoted(verdictOf(*advice.tool), '"', '"') << ",mesh,\n";
  }
  for (const ObjectAdvice& o : advice.objects) {
    file << o.name << ',' << std::quoted(o.verdict.text, '"', '"') << ',' << std::quoted(notJudgedOf(o), '"', '"')
         << ',' << std::quoted(notFeltOf(o), '"', '"') << '\n';
  }
  file.close();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

void writeToolCsv(const std::filesystem::path& path, const ToolAdvice& tool) {
  std::ofstream file(path);
  file << "tool,spacing_mm,points,advised,epsilon_p99_ratio,epsilon_max_ratio,torque_epsilon_p99_ratio,hot_tick_p50_ns,"
          "pass\n";
  for (std::size_t i = 0; i < tool.candidates.size(); ++i) {
    const SpacingCandidate& c = tool.candidates[i];
    file << std::quoted(tool.name, '"', '"') << ',' << 1e3 * c.spacing_m << ',' << c.points << ','
         << (i == tool.advised) << ',' << c.difference.epsilon_p99 << ',' << c.difference.epsilon_max << ','
         << c.torque_p99 << ',' << c.hot_ns << ',' << c.good() << '\n';
  }
  file.close();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

void apply(const AdviseOptions& options, const std::vector<LoadedObject>& scene, SceneAdvice& advice) {
  constexpr std::uint64_t kSeed = 1000;
  const auto written = writeAdvised(advice, options.scene, options.assets, options.apply);
  const auto checks = checkedAgainst(written, scene, kSeed);
  std::printf("the advised scene: %s\n", (options.apply / std::filesystem::path(options.scene).filename()).c_str());
  if (advice.tool && advice.tool->replacesSpacing()) {
    std::vector<LoadedObject> others = scene;
    const auto held = std::ranges::find_if(others, &LoadedObject::held);
    const LoadedObject tool = *held;
    others.erase(held);
    const SpacingCandidate& advised = advice.tool->candidates[advice.tool->advised];
    advice.tool->checked = checkedSpacing(tool, advised.spacing_m, others, kSeed);
    std::printf("  %s: on other strokes the error is %.3f, of the torque %.3f, in 99 %% of %s ticks%s\n",
                tool.name.c_str(), advice.tool->checked->difference.epsilon_p99, advice.tool->checked->torque_p99,
                grouped(static_cast<std::size_t>(advice.tool->checked->difference.ticks)).c_str(),
                advice.tool->checkedWell() ? "" : ": IT IS FELT");
  }
  for (ObjectAdvice& object : advice.objects) {
    if (!object.verdict.use || !checks.contains(object.name)) continue;
    object.checked = checks.at(object.name);
    std::printf("  %s: on other strokes the error is below 1 in %.2f %% of %s ticks%s\n", object.name.c_str(),
                100 * (1 - object.checked->felt_ratio),
                grouped(static_cast<std::size_t>(object.checked->ticks)).c_str(),
                object.checkedWell() ? "" : ": IT IS FELT");
  }
}

}  // namespace

bool runAdvise(const AdviseOptions& options) {
  const auto found = findDevicePreset(options.devicePreset);
  if (!found) throw std::invalid_argument("--device-preset: " + found.error().text());
  const DevicePreset& device = *found;
  if (!options.apply.empty()) checkApply(options.scene, options.apply);
  const auto scene = orThrow(loadScene(options.scene, options.assets));
  SceneAdvice advice = adviceFor(scene, device, options.tolerance);
  print(advice, device);
  if (!options.apply.empty()) apply(options, scene, advice);
  writeRecords(options.out, "advise", recordsOf(advice, device));
  writeCsv(options.out / "advise.csv", advice);
  writeObjectsCsv(options.out / "advise_objects.csv", advice);
  if (advice.tool) writeToolCsv(options.out / "advise_tool.csv", *advice.tool);
  drawFigure("advise", figureOf(advice, options.scene), options.out / "advise");
  std::printf("written to %s: advise.json, advise.csv, advise_objects.csv, %sadvise.png, advise.svg\n",
              options.out.c_str(), advice.tool ? "advise_tool.csv, " : "");
  return (!advice.tool || advice.tool->checkedWell()) &&
         std::ranges::all_of(advice.objects, [](const ObjectAdvice& o) { return o.checkedWell() && o.holds(); });
}

}  // namespace haptics::eval

#include "tests/eval/advise/advise.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <functional>
#include <iomanip>
#include <stdexcept>

#include "common/text/grouped.h"
#include "tests/eval/advise/advice.h"
#include "tests/eval/advise/independent_check.h"
#include "tests/eval/advise/scene_writer.h"
#include "tests/eval/advise/verdict.h"
#include "tests/eval/figure/figure.h"
#include "tests/eval/figure/virtual_display.h"
#include "tests/eval/or_throw.h"

namespace haptics::eval {
namespace {

/// Okabe and Ito's, in turn.
constexpr std::array kColours{Colour{0.835, 0.369, 0.0}, Colour{0.0, 0.447, 0.698},   Colour{0.0, 0.62, 0.451},
                              Colour{0.8, 0.475, 0.655}, Colour{0.337, 0.706, 0.914}, Colour{0.902, 0.624, 0.0},
                              Colour{0.0, 0.0, 0.0}};

using Value = std::function<double(const Candidate&)>;

/// Its own mesh has no error against itself: it is left out where nothing is to be drawn.
Panel panelOf(const SceneAdvice& advice, const char* title, const char* label, const Value& value, int minDecade,
              double alwaysShown) {
  Panel panel{title, "triangles", label, {}, {}, {}};
  std::vector<double> xs;
  std::vector<double> ys{alwaysShown};
  for (std::size_t i = 0; i < advice.objects.size(); ++i) {
    const ObjectAdvice& object = advice.objects[i];
    Curve curve{i, {}};
    for (const Candidate& c : object.candidates) {
      if (!(value(c) > 0)) continue;
      curve.points.push_back({static_cast<double>(c.triangles), value(c), ""});
      xs.push_back(static_cast<double>(c.triangles));
      ys.push_back(value(c));
    }
    panel.curves.push_back(std::move(curve));
  }
  panel.x = decadesOf(xs);
  panel.y = decadesOf(ys);
  panel.y.low = std::max(panel.y.low, minDecade);
  return panel;
}

/// Where no rate is steady nothing is drawn.
Panel ratePanel(const SceneAdvice& advice) {
  Panel panel{"Rate, with its own damping", "stiffness, N/m", "lowest steady rate, Hz", {}, {}, {}};
  std::vector<double> xs;
  for (std::size_t i = 0; i < advice.objects.size(); ++i) {
    Curve curve{i, {}};
    for (const MaterialOption& option : advice.objects[i].options) {
      const auto rate = option.steadyFrom();
      if (option.damping_Ns_per_m != advice.objects[i].ownOption().damping_Ns_per_m) continue;
      xs.push_back(option.stiffness_N_per_m);
      if (rate) curve.points.push_back({option.stiffness_N_per_m, kRates_Hz[*rate], ""});
    }
    panel.curves.push_back(std::move(curve));
  }
  panel.x = decadesOf(xs);
  panel.y = decadesOf({kRates_Hz.begin(), kRates_Hz.end()});
  return panel;
}

Figure figureOf(const SceneAdvice& advice, const std::string& scene) {
  constexpr int kMinError = -3;
  Figure figure;
  figure.title = "What " + std::filesystem::path(scene).filename().string() + " needs";
  figure.caption = {
      "Decimated copies of each object against its own mesh, stroked with 1 N at 0.1 m/s, on the production contact "
      "core."};
  figure.columns = 2;
  const auto error = [](const Candidate& c) { return c.difference.epsilon_p99; };
  figure.panels.push_back(panelOf(advice, "Force error", "force error, 1: just noticeable", error, kMinError, 0.5));
  figure.panels.back().threshold = {1, "too small to notice"};
  const auto hot = [](const Candidate& c) { return c.hot_ns; };
  figure.panels.push_back(panelOf(advice, "Time, caches hot", "contact tick, ns (median)", hot, 0, 10));
  const auto memory = [](const Candidate& c) { return c.memory_MB; };
  figure.panels.push_back(panelOf(advice, "Memory", "server's database, MB", memory, kMinError, 0.1));
  figure.panels.push_back(ratePanel(advice));
  figure.legendTitle = "Object";
  for (std::size_t i = 0; i < advice.objects.size(); ++i) {
    const ObjectAdvice& o = advice.objects[i];
    std::string note = "not judged: no hand gets there";
    if (o.judged()) {
      const std::string own = std::to_string(o.candidates.front().triangles) + " triangles, ";
      note = own + (o.verdict.use ? std::to_string(o.mesh().triangles) + " are enough" : "kept");
    }
    figure.styles.push_back({o.name, note, kColours[i % kColours.size()], Marker::kDisc, false});
  }
  figure.legendNotes = {"Dashed: what a hand just notices."};
  for (const ObjectAdvice& o : advice.objects) {
    std::string names;
    for (const SceneFeature& feature : o.features) names += feature.judged() ? "" : ' ' + feature.name;
    if (!names.empty()) figure.legendNotes.push_back(o.name + ", not judged:" + names);
  }
  if (advice.rate) {
    figure.legendNotes.push_back("Lowest rate for all: " + std::to_string(std::lround(kRates_Hz[*advice.rate])) +
                                 " Hz");
  }
  return figure;
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
  constexpr std::uint64_t kSeed = 20;
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
  const auto display = orThrow(VirtualDisplay::ensure());
  orThrow(drawFigure(figureOf(advice, options.scene), options.out / "advise.png", options.out / "advise.svg"));
  std::printf("written to %s: advise.json, advise.csv, advise_objects.csv, %sadvise.png, advise.svg\n",
              options.out.c_str(), advice.tool ? "advise_tool.csv, " : "");
  return (!advice.tool || advice.tool->checkedWell()) &&
         std::ranges::all_of(advice.objects, [](const ObjectAdvice& o) { return o.checkedWell() && o.holds(); });
}

}  // namespace haptics::eval

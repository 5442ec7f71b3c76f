#include "tests/eval/advise/advice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tuple>

#include "tests/eval/advise/verdict.h"

namespace haptics::eval {
namespace {

/// The lowest rate at which every judged object has a good option.
std::optional<std::size_t> lowestRate(const std::vector<ObjectAdvice>& objects) {
  if (std::ranges::none_of(objects, &ObjectAdvice::judged)) return std::nullopt;
  for (std::size_t rate = 0; rate < kRates_Hz.size(); ++rate) {
    const auto serves = [&](const ObjectAdvice& o) {
      return !o.judged() || (o.optionAt(rate) != nullptr && kRates_Hz[rate] >= o.textureRate_Hz);
    };
    if (std::ranges::all_of(objects, serves)) return rate;
  }
  return std::nullopt;
}

/// Scenes of many objects take minutes.
void tell(const char* doing, const std::string& object) { std::fprintf(stderr, "%s %s ...\n", doing, object.c_str()); }

}  // namespace

const MaterialOption& ObjectAdvice::ownOption() const {
  return *std::ranges::find_if(options, [](const MaterialOption& option) { return option.own; });
}

const MaterialOption* ObjectAdvice::optionAt(std::size_t rate) const {
  const MaterialOption& own = ownOption();
  if (own.trials[rate].steady) return own.trials[rate].good() ? &own : nullptr;
  const auto farFromOwn = [&](const MaterialOption& option) {
    return std::tuple(std::abs(std::log(option.stiffness_N_per_m / own.stiffness_N_per_m)),
                      std::abs(option.damping_Ns_per_m - own.damping_Ns_per_m));
  };
  const MaterialOption* nearest = nullptr;
  for (const MaterialOption& option : options) {
    if (!option.trials[rate].good()) continue;
    if (nearest == nullptr || farFromOwn(option) < farFromOwn(*nearest)) nearest = &option;
  }
  return nearest;
}

std::string ObjectAdvice::stepBetween(const MaterialOption& from, const MaterialOption& to) const {
  const auto dampings = std::ranges::count(options, from.stiffness_N_per_m, &MaterialOption::stiffness_N_per_m);
  const std::ptrdiff_t apart = &to - &from;  // by stiffness, then damping
  const std::string way = apart > 0 ? " up" : " down";
  if (std::abs(apart) == dampings) return "stiffness" + way;
  if (std::abs(apart) == 1 && from.stiffness_N_per_m == to.stiffness_N_per_m) return "damping" + way;
  return "";
}

const MaterialOption& SceneAdvice::optionOf(const ObjectAdvice& object) const {
  const MaterialOption* option = rate ? object.optionAt(*rate) : nullptr;
  return option != nullptr ? *option : object.ownOption();
}

RateSummary summaryAt(const SceneAdvice& advice, std::size_t rate, const DevicePreset& device) {
  RateSummary summary;
  double slowest_ns = 0;
  for (const ObjectAdvice& object : advice.objects) {
    if (!object.judged()) continue;
    const MaterialOption* good = object.optionAt(rate);
    const Trial& trial = (good != nullptr ? *good : object.ownOption()).trials[rate];
    const auto fails = [&](bool does, const char* criterion) {
      if (does) summary.fails.push_back(criterion + object.name);
    };
    fails(!trial.steady, "rest on ");
    fails(trial.tap.epsilon_p99 >= 1, "tap on ");
    fails(trial.stroke.epsilon_p99 >= 1 || trial.stroke.wrongSideTicks > 0, "stroke over ");
    fails(kRates_Hz[rate] < object.textureRate_Hz, "pattern of ");
    summary.epsilon_p99 = std::max(summary.epsilon_p99, trial.epsilon_p99());
    summary.worstCycle_um = std::max(summary.worstCycle_um, trial.worstCycle_um);
    for (const std::string& what : trial.happens) summary.unsteady.push_back(object.name + ", " + what);
    slowest_ns = std::max(slowest_ns, object.mesh().hot_ns);
  }
  summary.core_ratio = slowest_ns * 1e-9 * kRates_Hz[rate];
  summary.passiveTo_N_per_m = std::min(2 * device.viscousFriction_Ns_per_m * kRates_Hz[rate],
                                       2 * device.coulombFriction_N / device.resolution_m);
  return summary;
}

SceneAdvice adviceFor(std::vector<LoadedObject> scene, const DevicePreset& device, double tolerance) {
  SceneAdvice advice;
  const auto held = std::ranges::find_if(scene, &LoadedObject::held);
  if (held != scene.end()) {
    tell("spacing of", held->name);
    const LoadedObject tool = *held;
    scene.erase(held);
    advice.tool = toolAdviceFor(tool, scene);
  }
  const std::vector<LoadedObject> whole = scene;
  for (LoadedObject& object : scene) object.detail = shadingOf(object.material, *object.surface);
  std::vector<LoadedObject> advised = scene;
  std::vector<std::vector<HandStroke>> strokes;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    tell("meshes of", scene[i].name);
    ObjectAdvice object;
    object.name = scene[i].name;
    strokes.push_back(strokesOver(scene[i]));
    if (!strokes[i].empty()) {
      object.candidates = candidatesFor(scene, i, strokes[i], tolerance);
    }
    decide(object, scene, i);
    object.features = featuresOf(whole, i, strokes[i]);
    object.textureRate_Hz = patternRate_Hz(scene[i].material.surface, object.features);
    if (object.verdict.use) {
      advised[i].mesh = object.mesh().mesh;
      advised[i].surface = object.mesh().surface;
      advised[i].detail = shadingOf(scene[i].material, *object.mesh().surface);
    }
    advice.objects.push_back(std::move(object));
  }
  for (std::size_t i = 0; i < scene.size(); ++i) {
    if (!advice.objects[i].judged()) continue;
    tell("failure motions on", scene[i].name);
    advice.objects[i].motions = failureMotionsOf(servoSceneOf(advised), advised[i], strokes[i]);
    tell("rates and options of", scene[i].name);
    advice.objects[i].options = optionsFor(advised, i, strokes[i], device);
  }
  advice.rate = lowestRate(advice.objects);
  return advice;
}

}  // namespace haptics::eval

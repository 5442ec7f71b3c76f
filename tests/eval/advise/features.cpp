#include "tests/eval/advise/features.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "common/wire/checks.h"
#include "haptic_server/engine/step/haptic_step.h"
#include "haptic_server/scene/effect_limits.h"
#include "tests/eval/advise/felt_forces.h"
#include "tests/eval/timing.h"

namespace haptics::eval {
namespace {

constexpr double kJudged_Hz = 1000;
constexpr double kNone_m = std::numeric_limits<double>::infinity();

double tick_ns(const ServoScene& scene, const HandStroke& hand) {
  constexpr std::size_t kBatch = 16;  // a single tick is no longer than reading the clock
  const StepConfig config{.period_s = 1 / kJudged_Hz, .maxForce_N = 1e9};
  HapticState state(config);
  (void)adoptScene(scene, state, 0);  // the first is always taken
  Stopwatch watch;
  const std::vector<Vec3> places = hand.places();
  for (std::size_t i = 0; i + kBatch <= places.size(); i += kBatch) {
    watch.time([&] {
      for (std::size_t k = i; k < i + kBatch; ++k) {
        (void)hapticStep(scene, state, config, {k, 0, {places[k], DeviceState::kReady}});
      }
    });
  }
  return watch.durations_ns().quantile(0.5) / kBatch;
}

void addUnjudged(const LoadedObject& object, std::vector<SceneFeature>& features) {
  const auto add = [&](bool has, const char* name, const char* why) {
    if (has) features.push_back({name, why});
  };
  const SurfaceProperties& surface = object.material.surface;
  add(surface.stiffnessOver.has_value(), "stiffness_over", "judged as equally stiff everywhere");
  add(surface.softnessOver.has_value(), "softness_over", "judged as rigid");
  add(object.deformation.softness.has_value(), "softness", "judged as rigid");
  add(object.deformation.lattice.has_value(), "lattice", "judged as the mesh is without it");
  add(object.deformation.residue.has_value(), "residue", "judged as the mesh is without it");
  for (std::size_t i = 0; i < object.effects.size(); ++i) {
    const std::string name = "effects[" + std::to_string(i) + "]";
    const double most_N = strongest_N(object.effects[i]);
    const bool isNoticed = most_N >= kNoticed_N;
    features.push_back(
        {name, isNoticed ? "no part of the surface" : "not felt, with " + numberText(most_N) + " N at most"});
  }
  if (!object.motion) return;
  add(!object.motion->fixed, "motion", "judged at rest");
  add(object.motion->collision.has_value(), "collision", "judged by the hand alone");
}

double finest_m(const FieldFamily& family) {
  struct {
    double operator()(const FourierFamily& of) const {
      return std::ranges::min_element(of.terms, {}, &FourierTerm::wavelength_m)->wavelength_m;
    }
    double operator()(const NoiseFamily& of) const {
      return std::ldexp(of.wavelength_m, 1 - static_cast<int>(of.octaves));
    }
    double operator()(const CellularFamily& of) const { return of.cell_m; }
    double operator()(const GrainFamily& of) const { return 2 * of.grain_m; }
    double operator()(const MappedFamily&) const { return kNone_m; }
    double operator()(const GrownFamily&) const { return kNone_m; }
    double operator()(const LayeredFamily& of) const {
      double finest = kNone_m;
      for (const FieldLayer& layer : of.layers) finest = std::min(finest, finest_m(layer.family));
      return finest;
    }
  } const visitor;
  return std::visit(visitor, family);
}

double finest_m(const FactorMap& map) {
  const auto* family = std::get_if<FieldFamily>(&map);
  return family == nullptr ? kNone_m : finest_m(*family);
}

}  // namespace

std::vector<SceneFeature> featuresOf(const std::vector<LoadedObject>& scene, std::size_t object,
                                     const std::vector<HandStroke>& strokes) {
  std::vector<SceneFeature> features;
  const ServoScene whole = servoSceneOf(scene);
  const SurfaceDetail* own = scene[object].detail.get();
  const auto judge = [&](const char* name, bool has, const std::function<void(SurfaceDetail&)>& remove) {
    if (!has) return;
    if (strokes.empty()) return features.push_back({name, "no hand gets there from above"});
    auto without = std::make_shared<SurfaceDetail>(*own);
    remove(*without);
    ServoScene varied = whole;
    varied.objects[object].detail = without;
    SceneFeature feature{name, ""};
    feature.epsilon_p99 =
        differenceOf(forcesIn(varied, strokes, kJudged_Hz), forcesIn(whole, strokes, kJudged_Hz)).epsilon_p99;
    feature.cost_ns = tick_ns(whole, strokes.front()) - tick_ns(varied, strokes.front());
    features.push_back(feature);
  };
  if (own != nullptr) {
    judge("shading", own->shading != nullptr, [](SurfaceDetail& detail) { detail.shading = nullptr; });
    judge("friction", own->friction.has_value(), [](SurfaceDetail& detail) { detail.friction.reset(); });
    judge("texture", own->texture.has_value(), [](SurfaceDetail& detail) { detail.texture.reset(); });
    judge("tap", own->scalars.tap_Ns_per_m > 0, [](SurfaceDetail& detail) { detail.scalars.tap_Ns_per_m = 0; });
  }
  addUnjudged(scene[object], features);
  return features;
}

double patternRate_Hz(const SurfaceProperties& surface, const std::vector<SceneFeature>& features) {
  constexpr double kTicksToAWave = 10;
  constexpr double kSpeed_m_per_s = 0.1;
  const auto isFelt = [&](const char* name) {
    const auto found = std::ranges::find(features, name, &SceneFeature::name);
    return found != features.end() && found->felt();
  };
  double finest = kNone_m;
  if (surface.texture && isFelt("texture")) finest = finest_m(surface.texture->family);
  if (surface.friction && isFelt("friction")) {
    finest = std::min({finest, finest_m(surface.friction->over), finest_m(surface.friction->dynamicOver)});
  }
  return finest == kNone_m ? 0 : kTicksToAWave * kSpeed_m_per_s / finest;
}

}  // namespace haptics::eval

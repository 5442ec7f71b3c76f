#include "tests/eval/advise/material_option.h"

#include <algorithm>

#include "haptic_server/step/haptic_step.h"
#include "tests/eval/advise/steadiness.h"

namespace haptics::eval {
namespace {

/// A place on an object, where the simulated device is put.
struct RestingPlace {
  Vec3 place{0};
  Vec3 normal{0};
};

/// Of all strokes' places on the surface the one that lies most level: a hand reaches it best.
RestingPlace levelPlace(const LoadedObject& object, const std::vector<HandStroke>& strokes) {
  RestingPlace best;
  double most = -2;
  for (const HandStroke& hand : strokes) {
    for (const Vec3 hip : hand.stroke) {
      int spent = 0;
      const ClosestPoint foot = object.surface->closestFoot(
          toLocal(object.pose, hip), static_cast<int>(object.surface->triangleCount()) + 1, spent);
      const Vec3 normal = object.pose.rotation * object.surface->normal(foot);
      if (normal.z <= most) continue;
      most = normal.z;
      best = {toWorld(object.pose, foot.point), normal};
    }
  }
  return best;
}

Vec3 placeAt(const std::vector<Vec3>& places, double time_ms) {
  const auto before = std::min(static_cast<std::size_t>(time_ms), places.size() - 2);
  return glm::mix(places[before], places[before + 1], time_ms - static_cast<double>(before));
}

/// The production step along each stroke, before the limit of a device, as it is at every second millisecond: those are
/// ticks at every rate. A lower rate's force comes later, by less than a hand notices; what is compared is the force.
std::vector<Forces> forcesIn(const ServoScene& scene, const std::vector<HandStroke>& strokes, double rate_Hz) {
  const StepConfig config{.period_s = 1 / rate_Hz, .maxForce_N = 1e9};
  const auto apart = static_cast<std::size_t>(rate_Hz / 500);
  std::vector<Forces> all;
  for (const HandStroke& hand : strokes) {
    Forces& forces_N = all.emplace_back();
    const std::vector<Vec3> places = hand.places();
    HapticState state(config);
    (void)adoptScene(scene, state, 0);  // the first is always taken
    const auto ticks = static_cast<std::size_t>(static_cast<double>(places.size() - 1) * 1e-3 * rate_Hz);
    for (std::size_t tick = 0; tick <= ticks; ++tick) {
      const Vec3 hip = placeAt(places, 1e3 * static_cast<double>(tick) / rate_Hz);
      const TelemetrySample sample = hapticStep(scene, state, config, {tick, 0, {hip, DeviceState::kReady}});
      if (tick % apart == 0) forces_N.push_back(sample.force.contact);
    }
  }
  return all;
}

void rest(const ServoScene& scene, const RestingPlace& at, const DevicePreset& device, double rate_Hz, Trial& trial) {
  for (const char* hand : {"none", "light"}) {
    const Steadiness found = restOn(scene, at.place, at.normal, device, findHandPreset(hand).value(), rate_Hz);
    trial.worstCycle_um = std::max(trial.worstCycle_um, found.cycle_um);
    if (found.steady) continue;
    trial.steady = false;
    trial.happens.push_back(std::string("hand ") + hand + (found.touching ? ": limit cycle" : ": contact lost"));
  }
}

}  // namespace

std::optional<std::size_t> MaterialOption::steadyFrom() const noexcept {
  const auto found = std::ranges::find_if(trials, [](const Trial& trial) { return trial.steady; });
  if (found == trials.end()) return std::nullopt;
  return static_cast<std::size_t>(found - trials.begin());
}

std::vector<MaterialOption> optionsFor(const std::vector<LoadedObject>& scene, const std::vector<LoadedObject>& advised,
                                       std::size_t object, const std::vector<HandStroke>& strokes,
                                       const DevicePreset& device) {
  constexpr std::array kOfStiffness{0.5, 1.0, 2.0};
  constexpr std::array kOfDamping{0.0, 0.5, 1.0, 2.0};
  const std::vector<Forces> truth = forcesIn(servoSceneOf(scene), strokes, kRates_Hz.back());
  const RestingPlace place = levelPlace(advised[object], strokes);
  const Material& own = scene[object].material;
  const double usualDamping = own.damping_Ns_per_m > 0 ? own.damping_Ns_per_m : Material{}.damping_Ns_per_m;
  ServoScene varied = servoSceneOf(advised);
  std::vector<MaterialOption> options;
  for (const double stiffness : kOfStiffness) {
    for (const double damping : kOfDamping) {
      MaterialOption option;
      option.stiffness_N_per_m = stiffness * own.stiffness_N_per_m;
      option.damping_Ns_per_m = damping * usualDamping;
      option.own = stiffness == 1 && option.damping_Ns_per_m == own.damping_Ns_per_m;
      varied.objects[object].stiffness_N_per_m = option.stiffness_N_per_m;
      varied.objects[object].damping_Ns_per_m = option.damping_Ns_per_m;
      for (std::size_t i = 0; i < kRates_Hz.size(); ++i) {
        Trial& trial = option.trials[i];
        trial.difference = differenceOf(forcesIn(varied, strokes, kRates_Hz[i]), truth);
        rest(varied, place, device, kRates_Hz[i], trial);
      }
      options.push_back(std::move(option));
    }
  }
  return options;
}

}  // namespace haptics::eval

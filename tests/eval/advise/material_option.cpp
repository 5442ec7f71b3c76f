#include "tests/eval/advise/material_option.h"

#include <algorithm>

#include "tests/eval/advise/felt_forces.h"
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

/// What the device holds in each tick of the highest rate, as if holding did not delay it: of the nearest tick.
std::vector<Forces> heldIn(const ServoScene& scene, const std::vector<HandStroke>& strokes, double rate_Hz) {
  const double ticks = rate_Hz / kRates_Hz.back();
  std::vector<Forces> all = forcesIn(scene, strokes, rate_Hz);
  for (Forces& forces_N : all) {
    Forces held_N(static_cast<std::size_t>(static_cast<double>(forces_N.size() - 1) / ticks) + 1);
    for (std::size_t i = 0; i < held_N.size(); ++i) {
      held_N[i] =
          forces_N[std::min(static_cast<std::size_t>(static_cast<double>(i) * ticks + 0.5), forces_N.size() - 1)];
    }
    forces_N = std::move(held_N);
  }
  return all;
}

/// Of each stroke what is along the surface, or what is not.
std::vector<Forces> partOf(const std::vector<Forces>& all, const std::vector<HandStroke>& strokes, bool along) {
  const auto perPlace = static_cast<std::size_t>(1e-3 * kRates_Hz.back());
  std::vector<Forces> parts;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::size_t begin = perPlace * strokes[i].down.size();
    const std::size_t end = begin + perPlace * strokes[i].stroke.size();
    Forces& part = parts.emplace_back();
    for (std::size_t k = 0; k < all[i].size(); ++k) {
      if ((k >= begin && k < end) == along) part.push_back(all[i][k]);
    }
  }
  return parts;
}

/// As long as the shorter of them: at a lower rate a stroke may end before its last place.
void compare(std::vector<Forces> felt, std::vector<Forces> truth, const std::vector<HandStroke>& strokes,
             Trial& trial) {
  for (std::size_t i = 0; i < felt.size(); ++i) {
    const std::size_t size = std::min(felt[i].size(), truth[i].size());
    felt[i].resize(size);
    truth[i].resize(size);
  }
  trial.tap = differenceOf(partOf(felt, strokes, false), partOf(truth, strokes, false));
  trial.stroke = differenceOf(partOf(felt, strokes, true), partOf(truth, strokes, true));
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

std::vector<MaterialOption> optionsFor(const std::vector<LoadedObject>& scene, std::size_t object,
                                       const std::vector<HandStroke>& strokes, const DevicePreset& device) {
  constexpr std::array kOfStiffness{0.5, 1.0, 2.0};
  constexpr std::array kOfDamping{0.0, 0.5, 1.0, 2.0};
  const std::vector<Forces> truth = forcesIn(servoSceneOf(scene), strokes, kRates_Hz.back());
  const RestingPlace place = levelPlace(scene[object], strokes);
  const Material& own = scene[object].material;
  const double usualDamping = own.damping_Ns_per_m > 0 ? own.damping_Ns_per_m : Material{}.damping_Ns_per_m;
  ServoScene varied = servoSceneOf(scene);
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
        compare(heldIn(varied, strokes, kRates_Hz[i]), truth, strokes, trial);
        rest(varied, place, device, kRates_Hz[i], trial);
      }
      options.push_back(std::move(option));
    }
  }
  return options;
}

}  // namespace haptics::eval

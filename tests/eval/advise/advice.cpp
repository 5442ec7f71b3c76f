#include "tests/eval/advise/advice.h"

#include <algorithm>
#include <array>

namespace haptics::eval {
namespace {

constexpr std::array kRates_Hz{500.0, 1000.0, 2000.0, 4000.0, 10'000.0};

/// A place on an object, where the simulated hand or device is put.
struct RestingPlace {
  std::string object;
  Vec3 place{0};
  Vec3 normal{0};
};

/// Of all strokes' places on the surface the one that lies most level: a hand reaches it best.
RestingPlace levelPlace(const LoadedObject& object, const std::vector<HandStroke>& strokes) {
  RestingPlace best{object.name};
  double most = -2;
  for (const HandStroke& hand : strokes) {
    for (const Vec3 hip : hand.stroke) {
      int spent = 0;
      const Foot foot = object.surface->closestFoot(toLocal(object.pose, hip),
                                                    static_cast<int>(object.surface->triangleCount()) + 1, spent);
      const Vec3 normal = object.pose.rotation * object.surface->normal(foot);
      if (normal.z <= most) continue;
      most = normal.z;
      best.place = toWorld(object.pose, foot.point);
      best.normal = normal;
    }
  }
  return best;
}

RateAdvice restAt(double rate_Hz, const ServoScene& scene, const std::vector<RestingPlace>& places,
                  const DevicePreset& device) {
  RateAdvice advice{rate_Hz, true, 0, {}, 0};
  advice.passiveTo_N_per_m =
      std::min(2 * device.viscousFriction_Ns_per_m * rate_Hz, 2 * device.coulombFriction_N / device.resolution_m);
  for (const RestingPlace& at : places) {
    for (const char* hand : {"none", "light"}) {
      const Steadiness rest = restOn(scene, at.place, at.normal, device, findHandPreset(hand).value(), rate_Hz);
      advice.steady = advice.steady && rest.steady;
      if (!rest.steady)
        advice.unsteady.push_back(at.object + ", hand " + hand + (rest.touching ? ": limit cycle" : ": contact lost"));
      advice.worstCycle_um = std::max(advice.worstCycle_um, rest.cycle_um);
    }
  }
  return advice;
}

std::size_t advisedOf(const std::vector<Candidate>& candidates) {
  const auto bad = std::find_if(candidates.begin() + 1, candidates.end(), [](const Candidate& c) { return !c.good(); });
  return static_cast<std::size_t>(bad - candidates.begin()) - 1;
}

}  // namespace

const RateAdvice* SceneAdvice::advisedRate() const {
  const auto found = std::find_if(rates.begin(), rates.end(), [](const RateAdvice& r) { return r.steady; });
  return found == rates.end() ? nullptr : &*found;
}

SceneAdvice adviceFor(std::vector<LoadedObject> scene, const DevicePreset& device, double tolerance) {
  SceneAdvice advice;
  std::vector<RestingPlace> places;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    ObjectAdvice object{scene[i].name, {}, 0};
    const std::vector<HandStroke> strokes = strokesOver(scene[i]);
    if (!strokes.empty()) {
      object.candidates = candidatesFor(scene, i, strokes, tolerance);
      object.advised = advisedOf(object.candidates);
      places.push_back(levelPlace(scene[i], strokes));
    }
    advice.objects.push_back(std::move(object));
  }
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const ObjectAdvice& object = advice.objects[i];
    if (!object.candidates.empty()) scene[i].surface = object.candidates[object.advised].surface;
  }
  const ServoScene advised = servoSceneOf(scene);
  for (const double rate_Hz : kRates_Hz) advice.rates.push_back(restAt(rate_Hz, advised, places, device));
  return advice;
}

}  // namespace haptics::eval

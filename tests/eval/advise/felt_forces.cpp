#include "tests/eval/advise/felt_forces.h"

#include <algorithm>

#include "haptic_server/engine/step/haptic_step.h"

namespace haptics::eval {
namespace {

Vec3 placeAt(const std::vector<Vec3>& places, double time_ms) {
  const auto before = std::min(static_cast<std::size_t>(time_ms), places.size() - 2);
  return glm::mix(places[before], places[before + 1], time_ms - static_cast<double>(before));
}

}  // namespace

std::vector<Forces> forcesIn(const ServoScene& scene, const std::vector<HandStroke>& strokes, double rate_Hz) {
  const StepConfig config{.period_s = 1 / rate_Hz, .maxForce_N = 1e9};
  std::vector<Forces> all;
  for (const HandStroke& hand : strokes) {
    Forces& forces_N = all.emplace_back();
    const std::vector<Vec3> places = hand.places();
    HapticState state(config);
    (void)adoptScene(scene, state, 0);  // the first is always taken
    const auto ticks = static_cast<std::size_t>(static_cast<double>(places.size() - 1) * 1e-3 * rate_Hz);
    for (std::size_t tick = 0; tick <= ticks; ++tick) {
      const Vec3 hip = placeAt(places, 1e3 * static_cast<double>(tick) / rate_Hz);
      forces_N.push_back(hapticStep(scene, state, config, {tick, 0, {hip, DeviceState::kReady}}).force.contact);
    }
  }
  return all;
}

}  // namespace haptics::eval

#include "haptic_server/scene/effect_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "haptic_server/engine/motion/coupling.h"
#include "haptic_server/scene/make_rigid_body.h"

namespace haptics {

std::vector<Effect> stableEffects(std::vector<Effect> effects, std::optional<double> apparentMass_kg,
                                  const DeviceLimits& device) {
  double stiffness_N_per_m = 0, damping_Ns_per_m = 0;  // of the body's
  for (Effect& effect : effects) {
    effect.stiffness_N_per_m = std::min(effect.stiffness_N_per_m, device.stiffest_N_per_m);
    effect.damping_Ns_per_m = std::min(effect.damping_Ns_per_m, device.maxDamping_Ns_per_m);
    if (effect.frame == Effect::Frame::kWorld) continue;
    stiffness_N_per_m += effect.stiffness_N_per_m;
    damping_Ns_per_m += effect.damping_Ns_per_m;
  }
  if (!apparentMass_kg) return effects;
  const double share =
      stableStiffnessShare(*apparentMass_kg / device.hands, stiffness_N_per_m, damping_Ns_per_m, device.period_s);
  for (Effect& effect : effects) {
    if (effect.frame == Effect::Frame::kWorld) continue;
    effect.stiffness_N_per_m *= share;
    effect.damping_Ns_per_m *= share;
  }
  return effects;
}

double strongest_N(const Effect& effect) noexcept {
  using Kind = Effect::Kind;
  if (effect.kind == Kind::kSamples) {
    float loudest = 0;
    for (const float sample : effect.samples) loudest = std::max(loudest, std::abs(sample));
    return effect.amplitude_N * loudest;
  }
  if (effect.kind == Kind::kConstant || effect.kind == Kind::kVibration) return effect.amplitude_N;
  return effect.limit_N > 0 ? effect.limit_N : std::numeric_limits<double>::infinity();
}

std::vector<std::string> effectWarnings(const ObjectRecord& record, const ObjectAssets& assets,
                                        const DeviceLimits& device) {
  if (record.effects.empty()) return {};
  std::optional<double> apparentMass_kg;
  if (record.movesByItself()) {
    const auto body = bodyPartsOf(record, assets);
    if (body && *body && (*body)->body) apparentMass_kg = (*body)->apparentMass_kg;
  }
  const std::vector<Effect> felt = stableEffects(record.effects, apparentMass_kg, device);
  std::vector<std::string> warnings;
  for (std::size_t i = 0; i < felt.size(); ++i) {
    const Effect &is = felt[i], &asked = record.effects[i];
    const auto look = [&](const char* property, double its, double wanted, const char* unit) {
      if (its == wanted) return;
      std::ostringstream warning;
      warning.precision(4);
      warning << "warning: effects[" << i << "]'s " << property << " is felt as " << its << unit << " instead of "
              << wanted << ": the device, or the body that carries it, would not be stable with more";
      warnings.push_back(warning.str());
    };
    if (const double most_N = strongest_N(asked); most_N < kNoticed_N) {
      std::ostringstream warning;
      warning << "warning: effects[" << i << "] is not noticed: it pushes with " << most_N
              << " N at most, and a hand notices " << kNoticed_N << " N";
      warnings.push_back(warning.str());
    }
    look("stiffness", is.stiffness_N_per_m, asked.stiffness_N_per_m, " N/m");
    look("damping", is.damping_Ns_per_m, asked.damping_Ns_per_m, " N s/m");
  }
  return warnings;
}

}  // namespace haptics

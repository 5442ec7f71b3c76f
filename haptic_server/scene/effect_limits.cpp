#include "haptic_server/scene/effect_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "haptic_server/engine/motion/coupling.h"
#include "haptic_server/scene/make_rigid_body.h"

namespace haptics {
namespace {

/// Calls visit(speed, m/s, deviation) for each model of a recorded texture.
void forEachDeviation(const Effect& texture, const auto& visit) {
  const std::size_t forces = texture.forces_N.size(), count = texture.speeds_m_per_s.size() * forces;
  for (std::size_t i = 0; i < count; ++i)
    visit(texture.speeds_m_per_s[i / forces], texture.models[i * (texture.models.size() / count)]);
}

/// The force of a recorded texture grows with the hand's speed, to which it adds: by so much for each m/s at most, N s/m.
double steepness_Ns_per_m(const Effect& texture) {
  double steepest_s_per_m = 0;
  forEachDeviation(texture, [&](double speed_m_per_s, double deviation) {
    steepest_s_per_m = std::max(steepest_s_per_m, deviation / speed_m_per_s);
  });
  return texture.amplitude_N * steepest_s_per_m;
}

/// Without the observer, what pulls from both sides keeps a device moving that bears a wall as stiff, or as damped: by simulation of
/// every preset in nobody's hand and a light one, from up to 20 mm beside, it comes to rest on this share of the stiffness without
/// damping (on 0.3 of it some do not), on all of it with a tick's damping (0.5 ticks are too few), and with this share of the damping
/// (0.8 of it is too much).
constexpr double kUndampedShare = 0.2, kDampedShare = 0.5;
/// With the observer so many that are as stiff as a wall come to rest together: limits are half of what the device bears.
constexpr double kObservedTogether = 2;

/// It pulls from both sides, wherever the hand is.
[[nodiscard]] bool pullsEverywhere(const Effect& effect) noexcept {
  return effect.stiffness_N_per_m > 0 && effect.kind != Effect::Kind::kForbiddenSide && effect.reach_m == 0 &&
         effect.region == Effect::Region::kEverywhere;
}

/// No stiffer and no more damped than the device bears.
/// @param together  So many pull everywhere.
void limit(Effect& effect, const DeviceLimits& device, std::size_t together) {
  double stiffest_N_per_m = device.stiffest_N_per_m, maxDamping_Ns_per_m = device.maxDamping_Ns_per_m;
  if (pullsEverywhere(effect)) {
    const double sharing = static_cast<double>(together) / (device.observed ? kObservedTogether : 1);
    stiffest_N_per_m /= std::max(1.0, sharing);
    maxDamping_Ns_per_m /= std::max(1.0, sharing);
  }
  if (!device.observed && effect.kind != Effect::Kind::kForbiddenSide) {
    maxDamping_Ns_per_m *= kDampedShare;
    stiffest_N_per_m =
        std::clamp(effect.damping_Ns_per_m / device.period_s, kUndampedShare * stiffest_N_per_m, stiffest_N_per_m);
  }
  effect.stiffness_N_per_m = std::min(effect.stiffness_N_per_m, stiffest_N_per_m);
  effect.damping_Ns_per_m = std::min(effect.damping_Ns_per_m, maxDamping_Ns_per_m);
}

}  // namespace

std::size_t pullingEverywhere(const std::vector<Effect>& effects) noexcept {
  return static_cast<std::size_t>(std::ranges::count_if(effects, pullsEverywhere));
}

std::vector<Effect> stableEffects(std::vector<Effect> effects, std::size_t together,
                                  std::optional<double> apparentMass_kg, const DeviceLimits& device) {
  double stiffness_N_per_m = 0, damping_Ns_per_m = 0;  // of the body's
  for (Effect& effect : effects) {
    limit(effect, device, together);
    if (effect.kind == Effect::Kind::kRecordedTexture) {
      const double steepness = steepness_Ns_per_m(effect);
      if (steepness > device.maxDamping_Ns_per_m) effect.amplitude_N *= device.maxDamping_Ns_per_m / steepness;
    }
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
  if (effect.kind == Kind::kRecordedTexture) {
    double strongest = 0;
    forEachDeviation(effect, [&](double, double deviation) { strongest = std::max(strongest, deviation); });
    constexpr double kDeviations = 4;  // 1 of 16,000 outputs is beyond
    const double most_N = kDeviations * effect.amplitude_N * strongest;
    return effect.limit_N > 0 ? std::min(effect.limit_N, most_N) : most_N;
  }
  if (effect.kind == Kind::kConstant || effect.kind == Kind::kVibration) return effect.amplitude_N;
  return effect.limit_N > 0 ? effect.limit_N : std::numeric_limits<double>::infinity();
}

std::vector<std::string> effectWarnings(const ObjectRecord& record, const ObjectAssets& assets, std::size_t together,
                                        const DeviceLimits& device) {
  if (record.effects.empty()) return {};
  std::optional<double> apparentMass_kg;
  if (record.movesByItself()) {
    const auto body = bodyPartsOf(record, assets);
    if (body && *body && (*body)->body) apparentMass_kg = (*body)->apparentMass_kg;
  }
  const std::vector<Effect> felt = stableEffects(record.effects, together, apparentMass_kg, device);
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
    if (asked.kind == Effect::Kind::kVibration && 2 * asked.frequency_Hz * device.period_s >= 1) {
      std::ostringstream warning;
      warning << "warning: effects[" << i << "]'s frequency of " << asked.frequency_Hz
              << " Hz is not felt: the servo's rate has room below " << 0.5 / device.period_s << " Hz";
      warnings.push_back(warning.str());
    }
    look("stiffness", is.stiffness_N_per_m, asked.stiffness_N_per_m, " N/m");
    look("amplitude", is.amplitude_N, asked.amplitude_N, " N");
    look("damping", is.damping_Ns_per_m, asked.damping_Ns_per_m, " N s/m");
  }
  return warnings;
}

}  // namespace haptics

#include "haptic_server/scene/effect_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

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

/// Of one by itself, the most that is felt.
struct Bearable {
  double stiffness_N_per_m, damping_Ns_per_m;
};

[[nodiscard]] Bearable bearable(Effect::Kind kind, double damping_Ns_per_m, const DeviceLimits& device) noexcept {
  const double stiffest_N_per_m = device.stiffest_N_per_m;
  if (device.observed || kind == Effect::Kind::kForbiddenSide) return {stiffest_N_per_m, device.maxDamping_Ns_per_m};
  return {std::clamp(damping_Ns_per_m / device.period_s, kUndampedShare * stiffest_N_per_m, stiffest_N_per_m),
          kDampedShare * device.maxDamping_Ns_per_m};
}

/// The ball in which it is felt, in its frame.
[[nodiscard]] std::pair<Vec3, double> ballOf(const Effect& effect) {
  using Region = Effect::Region;
  if (effect.region == Region::kBox) return {effect.point_m, glm::length(effect.size_m) / 2};
  if (effect.region == Region::kSphere) return {effect.point_m, effect.size_m.x / 2};
  const double held_m = std::max(effect.reach_m, effect.release_m);
  if (held_m > 0 && effect.kind == Effect::Kind::kSpringToPoint) return {effect.point_m, held_m};
  if (held_m > 0 && !effect.path_m.empty()) {
    Vec3 low = effect.path_m.front(), high = low;
    for (const Vec3& point : effect.path_m) low = glm::min(low, point), high = glm::max(high, point);
    return {(low + high) / 2.0, glm::distance(low, high) / 2 + held_m};
  }
  return {Vec3(0), std::numeric_limits<double>::infinity()};
}

}  // namespace

void EffectZones::add(const ObjectRecord& record) {
  for (const Effect& effect : record.effects) {
    const bool isInWorld = effect.frame == Effect::Frame::kWorld, moves = !isInWorld && record.motion.has_value();
    const Pose frame = isInWorld || moves ? Pose{} : record.pose;
    const auto [centre_m, radius_m] = ballOf(effect);
    const bool isAlong = effect.kind == Effect::Kind::kForbiddenSide || effect.kind == Effect::Kind::kSpringToPlane;
    zones_.push_back({record.id, moves, toWorld(frame, centre_m), radius_m,
                      isAlong ? frame.rotation * effect.direction : Vec3(0), effect.kind, effect.stiffness_N_per_m,
                      effect.damping_Ns_per_m});
  }
}

/// How much of one's pull the other's adds to: 0 where they are apart, or act across each other.
double EffectZones::together(const Zone& a, const Zone& b) noexcept {
  if (a.moves != b.moves || (a.moves && a.object != b.object)) return 1;
  if (glm::distance(a.centre_m, b.centre_m) > a.radius_m + b.radius_m) return 0;
  return a.along == Vec3(0) || b.along == Vec3(0) ? 1 : std::abs(glm::dot(a.along, b.along));
}

/// With parts d_j of what each may have by itself, and c_jk = together(), the part of d_j that is felt is 1 / max(1, sum_k c_jk d_k): then no
/// eigenvalue of what they sum up to at a place is above 1, by the row sums of the matrix c_jk sqrt(d_j d_k / (s_j s_k)), scaled by sqrt(d s).
std::vector<EffectShare> EffectZones::sharesOf(ObjectId object, const DeviceLimits& device) const {
  const auto part = [](double asked, double most) { return asked > 0 ? std::min(1.0, asked / most) : 0; };
  std::vector<EffectShare> shares;
  for (const Zone& zone : zones_) {
    if (zone.object != object) continue;
    double stiffness = 0, damping = 0;
    for (const Zone& other : zones_) {
      const Bearable most = bearable(other.kind, other.damping_Ns_per_m, device);
      const double weight = together(zone, other);
      stiffness += weight * part(other.stiffness_N_per_m, most.stiffness_N_per_m);
      damping += weight * part(other.damping_Ns_per_m, most.damping_Ns_per_m);
    }
    shares.push_back({1 / std::max(1.0, stiffness), 1 / std::max(1.0, damping)});
  }
  return shares;
}

std::vector<Effect> stableEffects(const ObjectRecord& record, const EffectZones& all,
                                  std::optional<double> apparentMass_kg, const DeviceLimits& device) {
  std::vector<Effect> effects = record.effects;
  const std::vector<EffectShare> shares = all.sharesOf(record.id, device);
  double stiffness_N_per_m = 0, damping_Ns_per_m = 0;  // of the body's
  for (std::size_t i = 0; i < effects.size(); ++i) {
    Effect& effect = effects[i];
    const Bearable most = bearable(effect.kind, effect.damping_Ns_per_m, device);
    effect.stiffness_N_per_m = shares[i].stiffness * std::min(effect.stiffness_N_per_m, most.stiffness_N_per_m);
    effect.damping_Ns_per_m = shares[i].damping * std::min(effect.damping_Ns_per_m, most.damping_Ns_per_m);
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
  constexpr double kFastest_m_per_s = 2;  // of a hand
  const double drag_N = kFastest_m_per_s * effect.damping_Ns_per_m;
  const double held_m = std::max(effect.reach_m, effect.release_m);
  double most_N = std::numeric_limits<double>::infinity();
  if (effect.kind == Kind::kViscosity) most_N = drag_N;
  if (held_m > 0) most_N = effect.stiffness_N_per_m * held_m + drag_N;
  return effect.limit_N > 0 ? std::min(effect.limit_N, most_N) : most_N;
}

std::vector<std::string> effectWarnings(const ObjectRecord& record, const ObjectAssets& assets, const EffectZones& all,
                                        const DeviceLimits& device) {
  if (record.effects.empty()) return {};
  std::optional<double> apparentMass_kg;
  if (record.movesByItself()) {
    const auto body = bodyPartsOf(record, assets);
    if (body && *body && (*body)->body) apparentMass_kg = (*body)->apparentMass_kg;
  }
  const std::vector<Effect> felt = stableEffects(record, all, apparentMass_kg, device);
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

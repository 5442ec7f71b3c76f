#include "haptic_server/engine/effects/effect_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/maths/elementary.h"
#include "haptic_server/engine/force/output_chain.h"

namespace haptics {
namespace {

using Kind = Effect::Kind;

/// 0 at the border and outside of it, 1 from `fade_m` inside on; C1 where that is more than 0.
[[nodiscard]] double fading(double inside_m, double fade_m) noexcept {
  if (inside_m <= 0) return 0;
  if (inside_m >= fade_m) return 1;
  const double t = inside_m / fade_m;
  return t * t * (3 - 2 * t);
}

/// The target went farther than the hand's own way makes of it where a path is not much bent.
[[nodiscard]] bool hasLeapt(Vec3 target, Vec3 targetBefore, Vec3 hip, Vec3 hipBefore) noexcept {
  return squaredLength(target - targetBefore) > 4 * squaredLength(hip - hipBefore);
}

}  // namespace

EffectField::EffectField(const Effect& effect)
    : effect_(effect),
      reach_m_(effect.reach_m > 0 ? effect.reach_m : std::numeric_limits<double>::infinity()),
      release_m_(std::max(reach_m_, effect.release_m)) {
  if (!effect.path_m.empty()) path_ = EffectPath(effect.path_m);
}

bool EffectField::isPlaceOf(const EffectMemory& memory) const noexcept {
  const bool onPath = path_.segmentCount() == 0 ? memory.segment == 0 : memory.segment < path_.segmentCount();
  return onPath && memory.part >= 0 && memory.part <= 1;
}

Vec3 EffectField::limited(Vec3 force_N) const noexcept {
  return effect_.limit_N > 0 ? limitMagnitude(force_N, effect_.limit_N) : force_N;
}

EffectField::Felt EffectField::pull(EffectMemory& memory, Vec3 hip, Vec3 target, Vec3 damped) const noexcept {
  const Vec3 way = target - hip;
  const bool held = memory.holds;
  double weight = 1;
  memory.holds = true;
  if (effect_.reach_m > 0) {
    const double far_m = glm::length(way);
    memory.holds = far_m < (held ? release_m_ : reach_m_);
    weight = memory.holds ? fading(release_m_ - far_m, effect_.fade_m) : 0;
  }
  const bool jumped = held != memory.holds;
  if (weight == 0) return {Vec3(0), jumped};
  return {weight * limited(effect_.stiffness_N_per_m * way - effect_.damping_Ns_per_m * damped), jumped};
}

EffectField::Felt EffectField::pullToPath(EffectMemory& memory, Vec3 hip, Vec3 velocity) const noexcept {
  const bool held = memory.holds;
  const bool goesOn = effect_.kind == Kind::kGuide && held;
  const PathPlace place = goesOn ? path_.onwards(hip, memory.segment, memory.part) : path_.nearest(hip, memory.segment);
  const Vec3 tangent = path_.tangent(place);
  Felt felt = pull(memory, hip, place.point, velocity - glm::dot(velocity, tangent) * tangent);
  felt.jumped = felt.jumped || (held && hasLeapt(place.point, memory.target, hip, memory.hip));
  memory.segment = place.segment;
  memory.part = place.part;
  memory.hip = hip;
  memory.target = place.point;
  return felt;
}

/// As a surface's spring and damper, of which the damper does no more than the spring: it has no step at the plane.
Vec3 EffectField::pushOut(double depth_m, Vec3 normal, Vec3 velocity) const noexcept {
  if (depth_m <= 0) return Vec3(0);
  const double spring_N = effect_.stiffness_N_per_m * depth_m;
  const double damping_N = -effect_.damping_Ns_per_m * glm::dot(velocity, normal);
  return limited((spring_N + std::clamp(damping_N, -spring_N, spring_N)) * normal);
}

EffectField::Felt EffectField::keepInTube(EffectMemory& memory, Vec3 hip, Vec3 velocity) const noexcept {
  const PathPlace place = path_.nearest(hip, memory.segment);
  const double far_m = std::sqrt(place.squared_m2);
  const double depth_m = far_m - effect_.size_m.x / 2;
  const bool jumped = !memory.holds || (depth_m > 0 && hasLeapt(place.point, memory.target, hip, memory.hip));
  memory.holds = true;
  memory.segment = place.segment;
  memory.part = place.part;
  memory.hip = hip;
  memory.target = place.point;
  if (depth_m <= 0) return {Vec3(0), jumped};
  return {pushOut(depth_m, (place.point - hip) / far_m, velocity), jumped};
}

double EffectField::regionWeight(Vec3 hip) const noexcept {
  const Vec3 from = hip - effect_.point_m;
  switch (effect_.region) {
    case Effect::Region::kEverywhere:
    case Effect::Region::kInside:
      break;
    case Effect::Region::kBox: {
      const Vec3 inside = effect_.size_m / 2.0 - glm::abs(from);
      return fading(std::min({inside.x, inside.y, inside.z}), effect_.fade_m);
    }
    case Effect::Region::kSphere:
      return fading(effect_.size_m.x / 2 - glm::length(from), effect_.fade_m);
  }
  return 1;
}

EffectField::Felt EffectField::inRegion(EffectMemory& memory, Vec3 hip, Vec3 force_N) const noexcept {
  const double weight = regionWeight(hip);
  const bool held = memory.holds;
  memory.holds = weight > 0;
  return {weight * force_N, held != memory.holds};
}

/// The phase goes on where the frequency is edited.
EffectField::Felt EffectField::vibrate(EffectMemory& memory, Vec3 hip, double period_s) const noexcept {
  const auto sineAt = [&](double turns) { return elementary::sin(2 * std::numbers::pi * turns + effect_.phase_rad); };
  const double now = sineAt(memory.turns);
  const double step = effect_.frequency_Hz * period_s;
  Felt felt = inRegion(memory, hip, effect_.amplitude_N * now * effect_.direction);
  felt.byTime_N = effect_.amplitude_N * std::abs(now - sineAt(memory.turns - step));
  const double turns = memory.turns + step;
  memory.turns = turns - std::floor(turns);
  return felt;
}

EffectField::Felt EffectField::felt(EffectMemory& memory, Vec3 hip, Vec3 velocity, double period_s) const noexcept {
  const Vec3& n = effect_.direction;
  switch (effect_.kind) {
    case Kind::kConstant:
      return inRegion(memory, hip, effect_.amplitude_N * n);
    case Kind::kSpringToPoint:
      return pull(memory, hip, effect_.point_m, velocity);
    case Kind::kSpringToLine: {
      const Vec3 target = effect_.point_m + glm::dot(hip - effect_.point_m, n) * n;
      return pull(memory, hip, target, velocity - glm::dot(velocity, n) * n);
    }
    case Kind::kSpringToPlane:
      return pull(memory, hip, hip - glm::dot(hip - effect_.point_m, n) * n, glm::dot(velocity, n) * n);
    case Kind::kSpringToPath:
    case Kind::kGuide:
      return pullToPath(memory, hip, velocity);
    case Kind::kTube:
      return keepInTube(memory, hip, velocity);
    case Kind::kForbiddenSide: {
      const bool begins = !memory.holds;
      memory.holds = true;
      return {pushOut(glm::dot(effect_.point_m - hip, n), n, velocity), begins};
    }
    case Kind::kViscosity:
      return inRegion(memory, hip, limited(-effect_.damping_Ns_per_m * velocity));
    case Kind::kVibration:
      return vibrate(memory, hip, period_s);
    case Kind::kInertia:
    case Kind::kMagnet:
    case Kind::kSpringToVertex:
    case Kind::kSpringToEdge:
    case Kind::kSamples:
      break;
  }
  return {};
}

}  // namespace haptics

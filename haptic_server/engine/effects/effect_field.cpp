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

/// What one that is active may give the hand at once, and again in each second: the account has an end.
constexpr double kBudget_J = 5e-3;

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

EffectField::EffectField(const Effect& effect, double period_s)
    : effect_(effect),
      reach_m_(effect.reach_m > 0 ? effect.reach_m : std::numeric_limits<double>::infinity()),
      release_m_(std::max(reach_m_, effect.release_m)),
      isOfMesh_(effect.kind == Kind::kMagnet || effect.kind == Kind::kSpringToVertex ||
                effect.kind == Kind::kSpringToEdge || effect.kind == Kind::kRecordedTexture ||
                effect.region == Effect::Region::kInside),
      isActive_(effect.kind == Kind::kVibration || effect.kind == Kind::kSamples || isTexture()) {
  if (!effect.path_m.empty()) path_ = EffectPath(effect.path_m);
  if (isTexture()) texture_ = RecordedTexture(effect, period_s);
}

bool EffectField::isPlaceOf(const EffectMemory& memory) const noexcept {
  const bool onPath = path_.segmentCount() == 0 ? memory.segment == 0 : memory.segment < path_.segmentCount();
  return onPath && memory.part >= 0 && memory.part <= 1;
}

Vec3 EffectField::limited(Vec3 force_N) const noexcept {
  return effect_.limit_N > 0 ? limitMagnitude(force_N, effect_.limit_N) : force_N;
}

NearMesh EffectField::near(const CollisionMesh& mesh, Vec3 hip, Allowance& allowance) const noexcept {
  switch (effect_.kind) {
    case Kind::kMagnet:
      return nearestPlace(mesh, hip, release_m_, allowance);
    case Kind::kSpringToVertex:
      return nearestVertex(mesh, hip, release_m_, allowance);
    case Kind::kSpringToEdge:
      return nearestEdge(mesh, hip, release_m_, allowance);
    default:
      return inside(mesh, hip, effect_.fade_m, allowance);
  }
}

double EffectField::reachWeight(EffectMemory& memory, double far_m, bool& jumped) const noexcept {
  const bool held = memory.holds;
  memory.holds = far_m < (held ? release_m_ : reach_m_);
  jumped = held != memory.holds;
  return memory.holds ? fading(release_m_ - far_m, effect_.fade_m) : 0;
}

EffectField::Felt EffectField::pull(EffectMemory& memory, const Vec3& hip, const Vec3& target,
                                    const Vec3& damped) const noexcept {
  const Vec3 way = target - hip;
  bool jumped = !memory.holds;
  double weight = 1;
  if (effect_.reach_m > 0) {
    weight = reachWeight(memory, glm::length(way), jumped);
  } else {
    memory.holds = true;
  }
  if (weight == 0) return {Vec3(0), jumped};
  return {weight * limited(effect_.stiffness_N_per_m * way - effect_.damping_Ns_per_m * damped), jumped};
}

EffectField::Felt EffectField::pullToPath(EffectMemory& memory, const Vec3& hip, const Vec3& velocity) const noexcept {
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

[[gnu::noinline]] EffectField::Felt EffectField::pullToMesh(EffectMemory& memory, const Vec3& hip, const Vec3& velocity,
                                                            const NearMesh& mesh) const noexcept {
  const bool held = memory.holds;
  Felt felt;
  if (!mesh.isFound) {
    memory.holds = false;
    felt.jumped = held;
  } else if (effect_.kind == Kind::kMagnet) {
    const double far_m = glm::distance(mesh.point, hip);
    const double weight = reachWeight(memory, far_m, felt.jumped);
    if (far_m > 0) felt.force_N = weight * pushOut(far_m, (mesh.point - hip) / far_m, velocity);
  } else {
    felt = pull(memory, hip, mesh.point, velocity - glm::dot(velocity, mesh.along) * mesh.along);
  }
  felt.jumped = felt.jumped || (held && hasLeapt(mesh.point, memory.target, hip, memory.hip));
  memory.hip = hip;
  memory.target = mesh.point;
  return felt;
}

/// As a surface's spring and damper, of which the damper does no more than the spring: it has no step at the plane.
Vec3 EffectField::pushOut(double depth_m, Vec3 normal, const Vec3& velocity) const noexcept {
  if (depth_m <= 0) return Vec3(0);
  const double spring_N = effect_.stiffness_N_per_m * depth_m;
  const double damping_N = -effect_.damping_Ns_per_m * glm::dot(velocity, normal);
  return limited((spring_N + std::clamp(damping_N, -spring_N, spring_N)) * normal);
}

EffectField::Felt EffectField::keepInTube(EffectMemory& memory, const Vec3& hip, const Vec3& velocity) const noexcept {
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

double EffectField::regionWeight(const Vec3& hip, const NearMesh& mesh) const noexcept {
  const Vec3 from = hip - effect_.point_m;
  switch (effect_.region) {
    case Effect::Region::kEverywhere:
      break;
    case Effect::Region::kInside:
      if (!mesh.isFound) return 0;
      return effect_.fade_m > 0 ? fading(mesh.depth_m, effect_.fade_m) : 1;
    case Effect::Region::kBox: {
      const Vec3 inside = effect_.size_m / 2.0 - glm::abs(from);
      return fading(std::min({inside.x, inside.y, inside.z}), effect_.fade_m);
    }
    case Effect::Region::kSphere:
      return fading(effect_.size_m.x / 2 - glm::length(from), effect_.fade_m);
  }
  return 1;
}

EffectField::Felt EffectField::inRegion(EffectMemory& memory, double weight, Vec3 force_N) noexcept {
  const bool held = memory.holds;
  memory.holds = weight > 0;
  return {weight * force_N, held != memory.holds};
}

/// The mass goes on by backward Euler, by which it is stable on any spring. What of it comes in at the border is at rest, and what
/// stays behind there takes its momentum along: neither gives the hand energy.
[[gnu::noinline]] EffectField::Felt EffectField::carryMass(EffectMemory& memory, const Vec3& hip, const Vec3& velocity,
                                                           double weight, double period_s) const noexcept {
  if (!memory.holds) {
    memory.target = hip;
    memory.part = 0;
  }
  Felt felt = inRegion(memory, weight, Vec3(0));
  if (!memory.holds) return felt;
  if (weight > memory.part) memory.velocity *= memory.part / weight;
  memory.part = weight;
  const double k = effect_.stiffness_N_per_m, b = effect_.damping_Ns_per_m, mass_kg = weight * effect_.mass_kg;
  const Vec3 pull_N = k * (hip - memory.target) + b * velocity;
  const Vec3 next = (mass_kg * memory.velocity + period_s * pull_N) / (mass_kg + period_s * (b + period_s * k));
  const Vec3 asked_N = (b + period_s * k) * next - pull_N;
  felt.force_N = limited(asked_N);
  const Vec3 reached = asked_N == felt.force_N ? next : memory.velocity - period_s / mass_kg * felt.force_N;
  felt.byTime_N = glm::length(k * period_s * reached + b * (reached - memory.velocity));
  memory.velocity = reached;
  memory.target += period_s * reached;
  if (effect_.limit_N > 0) memory.target = hip + limited(k * (memory.target - hip)) / k;  // beyond it the mass slips
  memory.hip = hip;
  return felt;
}

void EffectField::takeOver(const EffectField& before, EffectMemory& memory) const noexcept {
  if (effect_.kind != Kind::kInertia) return;
  memory.velocity *= std::min(1.0, before.effect_.mass_kg / effect_.mass_kg);
  const double shorter = std::min(1.0, before.effect_.stiffness_N_per_m / effect_.stiffness_N_per_m);
  memory.target = memory.hip + shorter * (memory.target - memory.hip);
}

/// By the mean of so many places in the tick, a sample apart at most: of what is faster than ticks, the mean is felt. What ends
/// comes to nothing over one sample.
[[gnu::noinline]] EffectField::Felt EffectField::play(EffectMemory& memory, double weight,
                                                      double period_s) const noexcept {
  const auto count = static_cast<double>(effect_.samples.size());
  const bool once = effect_.trigger != Effect::Trigger::kAlways;
  if (once && !memory.holds) memory.turns = 0;
  const double step = effect_.sample_rate_Hz * period_s, places = std::ceil(step);
  const double end = once ? count + step : count;  // by a tick beyond the last sample nothing changes any more
  if (!(memory.turns >= 0 && memory.turns <= end)) memory.turns = 0;  // of other samples
  const auto at = [&](std::size_t i) -> double {
    if (i < effect_.samples.size()) return static_cast<double>(effect_.samples[i]);
    return once ? 0 : static_cast<double>(effect_.samples[i % effect_.samples.size()]);
  };
  const auto meanFrom = [&](double first) {
    double sum = 0;
    for (double j = 0; j < places; ++j) {
      const double place = std::max(first + step * j / places, 0.0);
      const auto i = static_cast<std::size_t>(place);
      sum += std::lerp(at(i), at(i + 1), place - std::floor(place));
    }
    return sum / places;
  };
  const double now = meanFrom(memory.turns);
  Felt felt = inRegion(memory, weight, effect_.amplitude_N * now * effect_.direction);
  const double before = memory.turns - step;
  felt.byTime_N = effect_.amplitude_N * std::abs(now - meanFrom(before < 0 && !once ? before + count : before));
  memory.turns = once ? std::min(memory.turns + step, end) : std::fmod(memory.turns + step, count);
  return felt;
}

/// The phase goes on where the frequency is edited.
EffectField::Felt EffectField::vibrate(EffectMemory& memory, double weight, double period_s) const noexcept {
  const auto sineAt = [&](double turns) { return elementary::sin(2 * std::numbers::pi * turns + effect_.phase_rad); };
  const double now = sineAt(memory.turns);
  const double step = effect_.frequency_Hz * period_s;
  Felt felt = inRegion(memory, weight, effect_.amplitude_N * now * effect_.direction);
  felt.byTime_N = effect_.amplitude_N * std::abs(now - sineAt(memory.turns - step));
  const double turns = memory.turns + step;
  memory.turns = turns - std::floor(turns);
  return felt;
}

EffectField::Felt EffectField::feltAlong(EffectMemory& memory, TextureMemory& texture, const Vec3& normal,
                                         double normal_N, const Vec3& velocity) const noexcept {
  const bool held = memory.holds;
  memory.holds = normal != Vec3(0);
  if (!memory.holds) return {Vec3(0), held && memory.force_N != Vec3(0)};
  if (!held) texture.restart();
  const RecordedTexture::Felt felt = texture_.felt(texture, normal, normal_N, velocity);
  return {limited(felt.force_N), false, felt.byTime_N};
}

void EffectField::keepToBudget(EffectMemory& memory, Felt& felt, double period_s, double given_J) noexcept {
  memory.part = std::clamp(memory.part + given_J / kBudget_J - period_s, 0.0, 1.0);
  const double share = std::min(2 * (1 - memory.part), 1.0);
  felt.force_N *= share;
  felt.byTime_N *= share;
}

EffectField::Felt EffectField::felt(EffectMemory& memory, const Vec3& hip, const Vec3& velocity, double period_s,
                                    const NearMesh& mesh) const noexcept {
  const Vec3& n = effect_.direction;
  switch (effect_.kind) {
    case Kind::kConstant:
      return inRegion(memory, regionWeight(hip, mesh), effect_.amplitude_N * n);
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
      return inRegion(memory, regionWeight(hip, mesh), limited(-effect_.damping_Ns_per_m * velocity));
    case Kind::kVibration:
      return vibrate(memory, regionWeight(hip, mesh), period_s);
    case Kind::kSamples:
      return play(memory, regionWeight(hip, mesh), period_s);
    case Kind::kInertia:
      return carryMass(memory, hip, velocity, regionWeight(hip, mesh), period_s);
    case Kind::kMagnet:
    case Kind::kSpringToVertex:
    case Kind::kSpringToEdge:
      return pullToMesh(memory, hip, velocity, mesh);
    case Kind::kRecordedTexture:
      break;
  }
  return {};
}

}  // namespace haptics

#pragma once

#include <algorithm>
#include <cmath>

#include "haptic_server/engine/step/groove_springs.h"
#include "haptic_server/engine/step/haptic_state.h"

namespace haptics {

/// Of a vector that two or three surfaces make, from the HIP to the IHIP that they hold or the force of their springs, the part
/// of the first one: the vector is the sum of their unit normals times these parts. `third` is zero when there are two.
[[nodiscard]] inline double heldPart(Vec3 vector, Vec3 first, Vec3 second, Vec3 third) noexcept {
  double share = glm::dot(vector, first);
  if (third != Vec3(0)) {
    const Vec3 others = glm::cross(second, third);
    const double volume = glm::dot(first, others);
    if (volume * volume > kMinSquaredSine) return glm::dot(vector, others) / volume;
  }
  const double cosine = glm::dot(first, second);
  const double squaredSine = 1 - cosine * cosine;
  if (squaredSine > kMinSquaredSine) share = (share - cosine * glm::dot(vector, second)) / squaredSine;
  return share;
}

/// Normal of a surface that holds the IHIP: outward, unit, world.
[[nodiscard]] inline Vec3 normalOf(const HapticState& state, const ContactSurface& held) noexcept {
  const Body& body = state.bodies[static_cast<std::size_t>(held.body)];
  return body.frame.rotate(body.surface->faceNormal(held.triangle) * double(held.side));
}

/// Normal of surface k of those that hold the IHIP, with force shading.
[[nodiscard]] inline Vec3 heldNormal(const HapticState& state, std::size_t k) noexcept {
  return state.groove.shaded ? state.groove.normal[k] : normalOf(state, state.contact.holding[k]);
}

/// heldPart() of the surface number k of those that hold the IHIP.
[[nodiscard]] inline double partOf(const HapticState& state, std::size_t k, Vec3 vector) noexcept {
  const std::size_t count = state.contact.surfaces().size();
  const auto normal = [&](std::size_t i) { return heldNormal(state, (k + i) % count); };
  return heldPart(vector, normal(0), normal(1), count > 2 ? normal(2) : Vec3(0));
}

/// Do surfaces of more than one body hold the IHIP?
[[nodiscard]] inline bool severalBodiesHold(const HapticState& state) noexcept {
  if (state.contact.holdingCount < 2) [[likely]]
    return false;
  const auto holding = state.contact.surfaces();
  return std::ranges::any_of(holding, [&](const ContactSurface& held) { return held.body != holding.front().body; });
}

/// The springs of the surfaces that hold the IHIP.
[[nodiscard]] inline GrooveSprings activeSprings(const HapticState& state) noexcept {
  GrooveSprings springs;
  for (std::size_t k = 0; k < state.contact.surfaces().size(); ++k) {
    const auto body = static_cast<std::size_t>(state.contact.holding[k].body);
    springs.add(heldNormal(state, k), state.objects[body].stiffness.value().spring_N_per_m);
  }
  return springs;
}

/// What bodies that hold the IHIP together make of the force (N) where the first one's spring was taken for all of the
/// penetration.
[[nodiscard]] inline Vec3 otherSprings_N(const HapticState& state, Vec3 penetration_m) noexcept {
  if (!severalBodiesHold(state)) return Vec3(0);
  const auto first = static_cast<std::size_t>(state.contact.holding[0].body);
  return activeSprings(state).force_N(penetration_m) -
         state.objects[first].stiffness.value().spring_N_per_m * penetration_m;
}

/// How deep (m) a body's spring is pressed that holds the IHIP with others; 0 of those that do not.
[[nodiscard]] inline double heldDepth_m(const HapticState& state, std::size_t body, Vec3 penetration_m) noexcept {
  const auto holding = state.contact.surfaces();
  const auto weight = activeSprings(state).weights(penetration_m);
  double own = 0;
  for (std::size_t k = 0; k < holding.size(); ++k) {
    if (static_cast<std::size_t>(holding[k].body) == body) own += weight[k];
  }
  return std::sqrt(own) * glm::length(penetration_m);
}

/// Spring force of all surfaces that hold the IHIP; N, world.
[[nodiscard]] inline Vec3 heldSpring_N(const HapticState& state, Vec3 penetration_m) noexcept {
  if (state.contact.surfaces().empty()) return Vec3(0);
  const auto first = static_cast<std::size_t>(state.contact.holding[0].body);
  return state.objects[first].stiffness.value().spring_N_per_m * penetration_m + otherSprings_N(state, penetration_m);
}

[[nodiscard]] inline bool holdsIhip(const HapticState& state, std::size_t body) noexcept {
  return state.contact.holds(static_cast<int>(body));
}

/// A tick of a contact that is let go, for an adoption that would break it: all that hold the IHIP lose the same part of
/// their springs, so that the force falls by RateLimitedStiffness::kRate_N_per_s, and at once by what the device does
/// not show.
inline void fadeHeld(HapticState& state, const StepConfig& config, Vec3 penetration_m) noexcept {
  const Vec3 force_N = heldSpring_N(state, penetration_m);
  const double length_N = glm::length(force_N);
  const double less_N =
      RateLimitedStiffness::kRate_N_per_s * config.period_s + std::max(0.0, length_N - config.maxForce_N);
  const double kept = length_N > less_N ? 1 - less_N / length_N : 0;
  for (std::size_t i = 0; i < state.objects.count; ++i) {
    if (holdsIhip(state, i)) state.objects[i].stiffness.fade(kept);
  }
  state.energy.attribute(state.report.object, EnergyFeature::kEdit, -(1 - kept) / 2 * glm::dot(force_N, penetration_m));
  state.adoption.fadeOut_s += config.period_s;
  state.limits.slew.begin();
}

}  // namespace haptics

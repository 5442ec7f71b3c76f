#pragma once

#include <algorithm>
#include <cmath>

#include "haptic_server/servo/haptic_state.h"

namespace haptics {

/// Of the vector from the HIP to an IHIP that two or three surfaces hold, the part that the first one pushes: the vector
/// is the sum of their unit normals times these parts. `third` is zero when there are two. Not negative.
[[nodiscard]] inline double heldShare(Vec3 penetration_m, Vec3 first, Vec3 second, Vec3 third) noexcept {
  // Normals closer together than this do not tell their parts apart; all is then the first one's.
  constexpr double kLeastSquaredSine = 1e-4;
  double share = glm::dot(penetration_m, first);
  if (third != Vec3(0)) {
    const Vec3 others = glm::cross(second, third);
    const double volume = glm::dot(first, others);
    if (volume * volume > kLeastSquaredSine) return std::max(0.0, glm::dot(penetration_m, others) / volume);
  }
  const double cosine = glm::dot(first, second);
  const double squaredSine = 1 - cosine * cosine;
  if (squaredSine > kLeastSquaredSine) share = (share - cosine * glm::dot(penetration_m, second)) / squaredSine;
  return std::max(0.0, share);
}

/// Of a surface that holds the IHIP: outward, unit, world.
[[nodiscard]] inline Vec3 normalOf(const HapticState& state, const HoldingSurface& held) noexcept {
  const Body& body = state.bodies[static_cast<std::size_t>(held.body)];
  return body.frame.turn(body.surface->faceNormal(held.triangle) * double(held.side));
}

/// heldShare() of the surface number k of those that hold the IHIP.
[[nodiscard]] inline double shareOf(const HapticState& state, std::size_t k, Vec3 penetration_m) noexcept {
  const auto holding = state.contact.surfaces();
  const auto normal = [&](std::size_t i) { return normalOf(state, holding[(k + i) % holding.size()]); };
  return heldShare(penetration_m, normal(0), normal(1), holding.size() > 2 ? normal(2) : Vec3(0));
}

/// Do surfaces of more than one body hold the IHIP?
[[nodiscard]] inline bool severalBodiesHold(const HapticState& state) noexcept {
  if (state.contact.holdingCount < 2) [[likely]]
    return false;
  const auto holding = state.contact.surfaces();
  return std::ranges::any_of(holding, [&](const HoldingSurface& held) { return held.body != holding.front().body; });
}

/// Calls visit(surface, share of the penetration in m) for those that hold the IHIP beside the body of the first one.
template <class Visit>
void visitOthers(const HapticState& state, Vec3 penetration_m, Visit visit) noexcept {
  const auto holding = state.contact.surfaces();
  for (std::size_t k = 1; k < holding.size(); ++k) {
    if (holding[k].body != holding.front().body) visit(holding[k], shareOf(state, k, penetration_m));
  }
}

/// Each body that holds the IHIP has a spring of its own for its part of the penetration: what that makes of the force (N)
/// where the first one's spring was taken for all of it. So the force has no step where another one becomes the first.
[[nodiscard]] inline Vec3 otherSprings_N(const HapticState& state, Vec3 penetration_m) noexcept {
  Vec3 sum_N(0);
  visitOthers(state, penetration_m, [&](const HoldingSurface& held, double share_m) noexcept {
    const auto stiffness = [&](int body) { return state.objects[static_cast<std::size_t>(body)].felt.value(); };
    const double more_N_per_m =
        stiffness(held.body).spring_N_per_m - stiffness(state.contact.holding[0].body).spring_N_per_m;
    sum_N += more_N_per_m * share_m * normalOf(state, held);
  });
  return sum_N;
}

/// Part of the penetration (m) that a body has which holds the IHIP with others; 0 for those that do not.
[[nodiscard]] inline double heldDepth_m(const HapticState& state, std::size_t body, Vec3 penetration_m) noexcept {
  const auto holding = state.contact.surfaces();
  Vec3 part_m(0);
  for (std::size_t k = 0; k < holding.size(); ++k) {
    if (static_cast<std::size_t>(holding[k].body) != body) continue;
    part_m += shareOf(state, k, penetration_m) * normalOf(state, holding[k]);
  }
  return glm::length(part_m);
}

/// Of all that hold the IHIP, N, world.
[[nodiscard]] inline Vec3 heldSpring_N(const HapticState& state, Vec3 penetration_m) noexcept {
  if (state.contact.surfaces().empty()) return Vec3(0);
  const auto first = static_cast<std::size_t>(state.contact.holding[0].body);
  return state.objects[first].felt.value().spring_N_per_m * penetration_m + otherSprings_N(state, penetration_m);
}

[[nodiscard]] inline bool holdsIhip(const HapticState& state, std::size_t body) noexcept {
  return std::ranges::any_of(state.contact.surfaces(),
                             [&](const HoldingSurface& held) { return static_cast<std::size_t>(held.body) == body; });
}

/// A tick of a contact that is let go, for an adoption that would break it: all that hold the IHIP lose the same part of
/// their springs, so that the force falls by FeltStiffness::kRate_N_per_s, and at once by what the device does not show.
inline void fadeHeld(HapticState& state, const StepConfig& config, Vec3 penetration_m) noexcept {
  const Vec3 force_N = heldSpring_N(state, penetration_m);
  const double length_N = glm::length(force_N);
  const double less_N = FeltStiffness::kRate_N_per_s * config.period_s + std::max(0.0, length_N - config.maxForce_N);
  const double kept = length_N > less_N ? 1 - less_N / length_N : 0;
  for (std::size_t i = 0; i < state.bodyCount; ++i) {
    if (holdsIhip(state, i)) state.objects[i].felt.fade(kept);
  }
  state.energy.name(state.contactObject, EnergyFeature::kEdit, -(1 - kept) / 2 * glm::dot(force_N, penetration_m));
  state.letGo_s += config.period_s;
  state.slew.begin();
}

}  // namespace haptics

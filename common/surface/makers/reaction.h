#pragma once

#include "common/scene/surface_edits.h"
#include "common/surface/lattice.h"

// Two substances that react with each other and diffuse at different rates, on whatever points (Barrio, Varea, Aragon &
// Maini 1999, Eq. (3)), u and v from their even state:
//   du/dt = D delta lap(u) + alpha u (1 - r1 v^2) + v (1 - r2 u)
//   dv/dt = delta lap(v) + beta v (1 + alpha r1 / beta u v) + gamma u + r2 u v
namespace haptics {

struct Substances {
  float u = 0, v = 0;
};

struct Reaction {
  static constexpr float kAlpha = 0.899F, kBeta = -0.91F, kGamma = -0.899F, kD = 0.516F;
  float r1, r2;  ///< Third order, which makes stripes; second order, which makes spots.
};

[[nodiscard]] inline Reaction reactionFor(ReactionDiffusionSource::Pattern pattern) noexcept {
  return pattern == ReactionDiffusionSource::Pattern::kStripes ? Reaction{3.5F, 0} : Reaction{0.5F, 0.3F};
}

/// The delta with which waves of this number grow fastest.
[[nodiscard]] inline float deltaFor(double waveNumber) noexcept {
  // delta times its square, where the larger eigenvalue of [alpha - D x, 1; gamma, beta - x] is the largest.
  constexpr double kFastest = 0.39676;
  return static_cast<float>(kFastest / (waveNumber * waveNumber));
}

/// A random start around the even state.
[[nodiscard]] inline float startNear0(Random& random) noexcept {
  constexpr double kWidth = 0.1;
  return static_cast<float>(kWidth * (random.uniform() - 0.5));
}

struct ReactionStep {
  Reaction reaction;
  float delta;
  float step;  ///< Of time.
};

/// After a step of Euler's. \param laplacian of both substances there.
[[nodiscard]] inline Substances reacted(Substances now, Substances laplacian, const ReactionStep& by) noexcept {
  const auto [a, b] = now;
  const auto [r1, r2] = by.reaction;
  const float cubic = Reaction::kAlpha * r1 * a * b * b, quadratic = r2 * a * b;
  const float du = Reaction::kD * by.delta * laplacian.u + Reaction::kAlpha * a - cubic + b - quadratic;
  const float dv = by.delta * laplacian.v + Reaction::kBeta * b + cubic + Reaction::kGamma * a + quadratic;
  return {a + by.step * du, b + by.step * dv};
}

}  // namespace haptics

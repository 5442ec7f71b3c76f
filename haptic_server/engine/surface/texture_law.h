#pragma once

#include <algorithm>

#include "common/maths/vec.h"

namespace haptics {

/// A height field over a surface, at one place.
struct HeightSample {
  double height_m = 0;  ///< h: of the felt surface over the geometric one.
  Vec3 gradient{0};     ///< Of h, in any frame; only its part along the surface counts.
};

/// Eq. (2): the normal of the surface with its texture, not of unit length. `normal` is N_s, unit.
[[nodiscard]] inline Vec3 perturbedNormal(Vec3 normal, Vec3 gradient) noexcept {
  return normal - gradient + glm::dot(gradient, normal) * normal;
}

/// Paper 4.3.1: d, the depth of penetration into the textured surface. @param nearestDistance_m  Of the HIP from the
/// geometric surface, negative inside: there is contact outside of it on bumps, and none within it in pits.
[[nodiscard]] inline double texturedDepth(double height_m, double nearestDistance_m) noexcept {
  return std::max(0.0, height_m - nearestDistance_m);
}

/// Eqs. (4a), (4b): the force over the stiffness, m. @param gain  K: 1 to 2, less for steep textures.
/// Not conservative. A loop of pressing p deep where the height is h1, sliding to h2 and lifting gives the hand
/// k p (h2 - h1) + k (1 - K) (h2^2 - h1^2) / 2; sideways it is a spring of k K (grad h grad h^T + h H(h)), however deep.
[[nodiscard]] inline Vec3 hoForce(double depth_m, Vec3 normal, const HeightSample& relief, double gain) noexcept {
  const Vec3 perturbed = perturbedNormal(normal, relief.gradient);
  const double part = gain * relief.height_m;
  return depth_m >= part ? (depth_m - part) * normal + part * perturbed : depth_m * perturbed;
}

/// Bump mapping, F = d M (paper 4.3.2, "the most intuitive way"): with M as it is, not normalised, it is conservative
/// on a plane, with the energy k d^2 / 2; sideways it is a spring of k (grad h grad h^T + d H(h)), stiffer the deeper.
[[nodiscard]] inline Vec3 bumpForce(double depth_m, Vec3 normal, const HeightSample& relief) noexcept {
  return depth_m * perturbedNormal(normal, relief.gradient);
}

}  // namespace haptics

#pragma once

#include <string>
#include <vector>

#include "tests/eval/advise/strokes.h"

namespace haptics::eval {

/// What an object has beyond its shape, stiffness and damping.
struct SceneFeature {
  std::string name;    ///< As the scene calls it: "texture".
  std::string whyNot;  ///< Why it is not judged; empty where it is.
  /// Of the force without it, from that with it: not exceeded in 99 % of the strokes' ticks.
  double epsilon_p99 = 0;
  double cost_ns = 0;  ///< Of a tick on the first stroke, median.

  [[nodiscard]] bool judged() const noexcept { return whyNot.empty(); }
  [[nodiscard]] bool felt() const noexcept { return epsilon_p99 >= 1; }
};

/// Shading, friction, texture and taps, each judged by the strokes in the production step with it and without; what else the
/// object has, not judged.
/// @param scene  With every detail of its surfaces.
[[nodiscard]] std::vector<SceneFeature> featuresOf(const std::vector<LoadedObject>& scene, std::size_t object,
                                                   const std::vector<HandStroke>& strokes);

/// Ten ticks to a wave of the finest pattern of texture and friction that is felt, at 0.1 m/s; 0 where there is none.
/// Images and computed patterns have no one wavelength and are left out.
[[nodiscard]] double patternRate_Hz(const SurfaceProperties& surface, const std::vector<SceneFeature>& features);

}  // namespace haptics::eval

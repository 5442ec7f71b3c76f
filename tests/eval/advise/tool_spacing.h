#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "haptic_server/simplification/force_difference.h"
#include "tests/eval/advise/loaded_scene.h"

namespace haptics::eval {

/// A spacing of a tool's points, judged against the scene's own by the same strokes over the same objects.
struct SpacingCandidate {
  double spacing_m = 0;
  std::size_t points = 0;
  ForceDifference difference;  ///< Of the force, from that at the scene's own spacing.
  double torque_p99 = 0;       ///< Of the torque: its error in what a hand can notice, in 99 % of the ticks.
  double hot_ns = 0;           ///< Tick on the strokes, median.

  [[nodiscard]] bool isFelt() const noexcept { return isAbove(1); }
  /// Not felt, with a tenth to spare for strokes that were not tried.
  [[nodiscard]] bool good() const noexcept { return !isAbove(0.9); }

 private:
  [[nodiscard]] bool isAbove(double error) const noexcept {
    return difference.wrongSideTicks > 0 || difference.epsilon_p99 >= error || torque_p99 >= error;
  }
};

/// What the tool that the hand holds needs.
struct ToolAdvice {
  std::string name;
  std::vector<SpacingCandidate>
      candidates;           ///< The own spacing first; none where there is nothing to touch from above.
  std::size_t advised = 0;  ///< The coarsest of which it and all finer ones are good.
  std::optional<SpacingCandidate> checked = std::nullopt;  ///< As written, by other strokes than it was advised by.

  [[nodiscard]] bool replacesSpacing() const noexcept { return advised > 0; }
  [[nodiscard]] bool checkedWell() const noexcept { return !checked || !checked->isFelt(); }
};

/// Strokes the tool over each object, as the simulated hand would choose it, pressed with 1 N on the tool's lowest point and
/// tilted to and fro, and as drawn at random, at the scene's spacing and at coarser ones, until two on end will not do.
/// @param scene  Objects but the tool, where the scene has them.
[[nodiscard]] ToolAdvice toolAdviceFor(const LoadedObject& tool, const std::vector<LoadedObject>& scene);

/// A spacing on strokes that are drawn at random; of a seed above 32, on none that it was advised by.
[[nodiscard]] SpacingCandidate checkedSpacing(const LoadedObject& tool, double spacing_m,
                                              const std::vector<LoadedObject>& scene, std::uint64_t seed);

}  // namespace haptics::eval

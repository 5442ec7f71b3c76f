#pragma once

#include <vector>

#include "common/maths/vec.h"

namespace haptics {

/// The forces of a stroke, N, world, one to a tick.
using Forces = std::vector<Vec3>;

/// How forces differ from those of the scene as it is, on the same strokes.
struct ForceDifference {
  double epsilon_p99 = 0;  ///< Error in what a hand can notice, not exceeded in 99 % of the ticks.
  double epsilon_max = 0;
  double felt_ratio = 0;   ///< Part of the ticks with an error of 1 or more.
  int ticks = 0;           ///< With contact in either.
  int missedTicks = 0;     ///< Without contact where the scene as it is has one, for more than one tick on end.
  int wrongSideTicks = 0;  ///< Pushed the other way.

  [[nodiscard]] bool safe() const noexcept { return missedTicks == 0 && wrongSideTicks == 0; }
  /// Not felt, with a tenth to spare for strokes that were not tried.
  [[nodiscard]] bool good() const noexcept { return safe() && epsilon_p99 < 0.9; }
};

/// @param felt, truth  Stroke by stroke, of the same lengths.
[[nodiscard]] ForceDifference differenceOf(const std::vector<Forces>& felt, const std::vector<Forces>& truth);

}  // namespace haptics

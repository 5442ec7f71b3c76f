#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/maths/vec.h"

namespace haptics {

/// Longest stroke in points. The simulated hand keeps a copy of the stroke that it is on, in fixed storage; a longer
/// one would be cut there.
inline constexpr std::size_t kMaxStrokePoints = 64;

/// One stroke along the upper side of an object, as a person looking at it would choose it: one to kMaxStrokePoints
/// points on the surface, evenly spaced, in the order of the stroke, world frame, metres. Nothing stands above them. A
/// single point is pressed, not stroked. Or a push against its side, from beside it to where it is to be pushed.
struct Stroke {
  std::uint64_t object = 0;
  std::vector<Vec3> points;
  bool isPush = false;

  bool operator==(const Stroke&) const = default;
};

/// What the simulated hand intends to explore: the strokes in turn, for ever. Immutable; made by the builder with each
/// scene that it publishes, read by the simulated hand on the servo thread.
struct ExplorationPlan {
  std::vector<Stroke> strokes;
  double clearHeight_m = 0;  ///< World z at which a hand passes over every object.

  bool operator==(const ExplorationPlan&) const = default;
};

}  // namespace haptics

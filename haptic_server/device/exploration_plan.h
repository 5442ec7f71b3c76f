#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/maths/vec.h"

namespace haptics {

/// One stroke along the upper side of an object, as a person looking at it would choose it: points on the surface in the
/// order of the stroke, world frame, metres.
struct Stroke {
  std::uint64_t object = 0;
  std::vector<Vec3> points;
};

/// What the simulated hand intends to explore: the strokes in turn, for ever. Immutable; made by the builder with each
/// scene that it publishes, read by the simulated hand on the servo thread.
struct ExplorationPlan {
  std::vector<Stroke> strokes;
};

}  // namespace haptics

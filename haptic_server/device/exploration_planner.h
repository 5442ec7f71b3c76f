#pragma once

#include <cstdint>
#include <span>

#include "common/maths/vec.h"
#include "haptic_server/device/exploration_plan.h"
#include "haptic_server/geometry/surface.h"

namespace haptics {

/// An object as the planner looks at it. Objects that are leaving the scene are not explored: leave them out.
struct ExploredObject {
  std::uint64_t id = 0;
  const Surface* surface = nullptr;  ///< Not null.
  Pose pose;
};

/// Chooses a stroke along the upper side (world +z) of each object, in the order given; an object that cannot be
/// reached from above has none. Depends on its arguments only: the same objects give the same plan, bit for bit. Some
/// thousand ray casts an object, and it allocates: for the builder thread.
[[nodiscard]] ExplorationPlan makeExplorationPlan(std::span<const ExploredObject> objects);

}  // namespace haptics

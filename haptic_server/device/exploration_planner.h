#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "common/maths/vec.h"
#include "haptic_server/device/exploration_plan.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// An object as the planner looks at it. Objects that are leaving the scene are not explored: leave them out.
struct ExploredObject {
  std::uint64_t id = 0;
  std::shared_ptr<const CollisionMesh> surface;  ///< Not null.
  Pose pose;
  bool moves = false;  ///< It can be pushed.

  bool operator==(const ExploredObject&) const = default;  ///< The very same surface.
};

/// Plans for one scene after another, and remembers the strokes: only that of an object that changed, or that stands
/// under one that did, is chosen anew.
class ExplorationPlanner {
 public:
  /// Chooses a stroke along the upper side (world +z) of each object, in the order given, and a push for each that moves;
  /// an object that cannot be reached from above has none. The same objects give the same plan, bit for bit, whatever was
  /// planned before. Some thousand ray casts an object, and it allocates: for the builder thread.
  [[nodiscard]] ExplorationPlan plan(std::span<const ExploredObject> objects);

 private:
  /// A stroke and all that it was chosen from: its object, then those that may hide parts of it.
  struct Choice {
    std::vector<ExploredObject> from;
    std::vector<Vec3> points, push;
  };
  std::map<std::uint64_t, Choice> choices_;  // of the last plan, by object
};

}  // namespace haptics

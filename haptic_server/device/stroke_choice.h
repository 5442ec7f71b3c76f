#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "common/maths/vec.h"

namespace haptics {

/// What one sees looking straight down. World frame, metres; the normal is a unit vector.
struct TopPoint {
  Vec3 position{0};
  Vec3 normal{0};
};

/// The topmost point of an object at (x, y), if it has one there and nothing hides it.
using TopView = std::function<std::optional<TopPoint>(double x, double y)>;

/// A straight row (seen from above) of evenly spaced points along the upper side of an object in the box from `low` to
/// `high`: long, on gentle slopes, away from edges, near the middle. Empty when the view shows nothing that is not too
/// steep.
[[nodiscard]] std::vector<Vec3> chooseStroke(const TopView& view, Vec3 low, Vec3 high);

}  // namespace haptics

#pragma once

#include <span>

#include "common/maths/vec.h"

namespace haptics {

/// A box on the floor, seen from above: metres, world frame.
struct FloorBox {
  glm::dvec2 low{0}, high{0};
  bool operator==(const FloorBox&) const = default;
};

/// Where the middle of a box of this size has to be to stand beside all others, near their middle.
/// @param gap_m  At least so far from each.
[[nodiscard]] glm::dvec2 freePlace(std::span<const FloorBox> others, glm::dvec2 size_m, double gap_m);

}  // namespace haptics

#pragma once

#include <array>

#include "common/maths/vec.h"

namespace haptics {

/// Normal of a triangle, as long as twice its area.
[[nodiscard]] inline Vec3 areaNormal(const std::array<Vec3, 3>& corner) {
  return glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
}

/// Of a place from a triangle that has an area; m^2 where both are in m, in one frame.
[[nodiscard]] double squaredDistance(Vec3 place, const std::array<Vec3, 3>& corner);

}  // namespace haptics

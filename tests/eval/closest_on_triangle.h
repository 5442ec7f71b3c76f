#pragma once

#include <array>

#include "common/maths/vec.h"

namespace haptics::eval {

/// Closest point of a triangle to p. Ericson, Real-Time Collision Detection, 5.1.5: another way than the production one.
[[nodiscard]] Vec3 closestOnTriangle(Vec3 p, const std::array<Vec3, 3>& triangle);

}  // namespace haptics::eval

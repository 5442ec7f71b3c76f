#pragma once

#include <span>
#include <vector>

#include "common/maths/vec.h"

namespace haptics {

/// Vertices on which a body can stand: those farthest out in kSupportDirections directions, spread evenly. Each is a
/// corner of the convex hull; a hull with fewer corners than that (a box: 8) is found whole. Of a rounder one there are
/// left out only corners that stand out by less than 0.004 of its radius of curvature.
/// Off the servo's thread: allocates, and looks at each vertex for each direction: about 1 s for a million vertices.
[[nodiscard]] std::vector<Vec3> supportPoints(std::span<const Vec3f> vertices);

/// Larger makes round bodies roll smoother and a tick near a plane longer: up to 1 ns for each.
inline constexpr int kSupportDirections = 1024;

}  // namespace haptics

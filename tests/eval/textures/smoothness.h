#pragma once

#include <functional>
#include <vector>

#include "common/scene/surface_properties.h"
#include "common/surface/scalar_field.h"
#include "tests/eval/random.h"

namespace haptics::eval {

/// A straight line along which a field is looked at. Object frame, m.
struct Walk {
  Vec3 from, to;
};

/// Where a field is looked at: points about a surface that it may lie on, and walks through them.
struct Region {
  std::function<Vec3(Random&)> point;
  std::vector<Walk> seams;  ///< Walks that cross every kind of seam there is.
};

/// A cube around the origin.
[[nodiscard]] Region cubeOf(double side_m);
/// About the intermediate surface, within a tenth of its size of it, poles and ends included. Seams: the borders of tiles,
/// where a turn closes, the axis, edges and corners of a box.
[[nodiscard]] Region regionOf(const Mapping& mapping, Random& random);

/// How a field keeps what section 4.3.3 of the paper asks for, C0 and C1.
struct Smoothness {
  double gradientError_ratio = 0;  ///< Largest |gradient - central difference|, of the largest gradient.
  double valueJump_ratio = 0;      ///< Largest that stays however near two points come, of the field's range;
  double gradientJump_ratio = 0;   ///< of the gradient, of the largest gradient.
};

/// Differences at random points, and along random walks and the seams a search for jumps: each of many short intervals
/// is halved again and again towards the half that changes more. Jumps of less than about 0.5 % of the largest gradient
/// may escape it.
[[nodiscard]] Smoothness smoothnessOf(const ScalarField& field, const Region& region, Random& random);

}  // namespace haptics::eval

#pragma once

#include <span>

#include "common/maths/vec.h"

namespace haptics {

/// amplitude * cos(k . x + phase).
struct PlaneWave {
  double amplitude;
  Vec3 k;  ///< rad/m.
  double phase_rad;
};

struct Range {
  double lowest, highest;
};

/// What a sum of plane waves stays within over all of space: never passed, and as a rule near to within 1 % of the sum of
/// the amplitudes. Waves whose vectors are whole combinations of three and fewer move together (harmonics, or three at
/// 120 degrees, which reach 3 but not below -3/2): their common extremes are searched for. Others are independent of them
/// and add their amplitudes, which is right unless they depend on each other.
[[nodiscard]] Range rangeOf(std::span<const PlaneWave> waves);

}  // namespace haptics

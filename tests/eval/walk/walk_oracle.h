#pragma once

#include "tests/eval/walk/obstacles.h"

namespace haptics::eval {

/// What can be said of an IHIP without knowing how it came there. World, metres; bodies at rest.
class WalkOracle {
 public:
  explicit WalkOracle(const TriangleSoup& soup);

  /// Deeper than kInside_m in a body that has an inside.
  [[nodiscard]] bool isInside(Vec3 ihip) const;
  /// Held though nothing is between it and the HIP.
  [[nodiscard]] bool isHeldByNothing(Vec3 ihip, Vec3 hip);
  /// No place that a short straight motion over what the IHIP rests on leads to is nearer to the HIP. Tries the ways
  /// along each surface, each line in which two meet and many others, `step` metres long: none where the IHIP, to
  /// rounding, is at the nearest place of all triangles that it is on. They could only tell how near that ends.
  [[nodiscard]] bool isLocalMinimum(Vec3 ihip, Vec3 hip, double step);

 private:
  [[nodiscard]] bool isHeldAtAGraze(Vec3 ihip, Vec3 hip);
  [[nodiscard]] bool isBetter(Vec3 from, Vec3 way, double step, Vec3 hip) const;

  const TriangleSoup& soup_;
  double skin_;
  Obstacles obstacles_;
};

}  // namespace haptics::eval

#pragma once

#include "tests/eval/random.h"
#include "tests/eval/walk/triangle_soup.h"

namespace haptics::eval {

/// Where a walk goes, and how fast.
struct WalkRange {
  double highest_m = 0.002;  ///< Above the surface.
  double deepest_m = 0.005;
  double fastest_m_per_s = 2;
  double startsApart_m = 0;  ///< From the sphere about everything.
};

/// A HIP that wanders about a scene, mostly in contact: it goes from one random place under or over the surface to the
/// next, near ones and far ones, each time at another speed.
class RandomWalker {
 public:
  RandomWalker(const TriangleSoup& soup, Random random, const WalkRange& range = {});

  [[nodiscard]] Vec3 hip() const { return hip_; }  ///< World, metres; first outside of everything.
  [[nodiscard]] Vec3 next();                       ///< One tick later.

 private:
  void choose();
  [[nodiscard]] const TriangleSoup::Face& someFace();

  const TriangleSoup& soup_;
  Random random_;
  WalkRange range_;
  Vec3 hip_{0};
  Vec3 target_{0};
  Vec3 velocity_{0};  // m/s
  double speed_ = 0;
};

}  // namespace haptics::eval

#pragma once

#include "tests/eval/random.h"
#include "tests/eval/walk/triangle_soup.h"

namespace haptics::eval {

/// A HIP that wanders about a scene, mostly in contact: it goes from one random place under or over the surface to the
/// next, near ones and far ones, each time at another speed, up to 2 m/s.
class RandomWalker {
 public:
  RandomWalker(const TriangleSoup& soup, Random random);

  [[nodiscard]] Vec3 hip() const { return hip_; }  ///< World, metres; first outside of everything.
  [[nodiscard]] Vec3 next();                       ///< One tick later.

 private:
  void choose();
  [[nodiscard]] const TriangleSoup::Face& someFace();

  const TriangleSoup& soup_;
  Random random_;
  Vec3 hip_{0};
  Vec3 target_{0};
  Vec3 velocity_{0};  // m/s
  double speed_ = 0;
};

}  // namespace haptics::eval

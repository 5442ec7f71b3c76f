#pragma once

#include "tests/eval/walk/random_walker.h"

namespace haptics::eval {

/// A hand that leads a tool as RandomWalker does a HIP, up to 1 m/s, and meanwhile turns it to and fro, up to 10 rad/s: to
/// random rotations about that which the tool has, for a hand does not turn far against what holds the tool.
class ToolWalker {
 public:
  ToolWalker(const TriangleSoup& soup, Random random);

  [[nodiscard]] Pose device() const { return {rotation_, position_.hip()}; }  ///< World; first outside of everything.
  [[nodiscard]] Pose next(const Pose& tool);                                  ///< One tick later.

 private:
  void choose(const Pose& tool);

  RandomWalker position_;
  Random random_;
  Quat rotation_, target_;
  Vec3 spin_{0};  // rad/s
  double speed_ = 0;
};

}  // namespace haptics::eval

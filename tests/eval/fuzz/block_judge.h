#pragma once

#include <span>

#include "common/maths/rotation.h"
#include "common/maths/vec.h"

namespace haptics::eval {

/// A box by half its sides, or a ball. Metres, world frame.
struct Block {
  Vec3 half_m;
  Pose pose;
  double mass_kg;  ///< 0: stands still.
  bool isBall = false;

  [[nodiscard]] double radius_m() const { return half_m.x; }  ///< Of a ball.
};

/// How deep two of them are in each other: the shortest way that parts them (m), of boxes by separating axes (Gottschalk,
/// Lin and Manocha, OBBTree, 1996). Negative where they are apart: no more than their distance.
[[nodiscard]] double overlapOf(const Block& a, const Block& b);

/// Does a stack stand? Boxes that lie flat, each on the one before it; the first is the ground. They do when at each joint the
/// centre of mass of everything above lies within what the two boxes share, by a tenth of its size.
[[nodiscard]] bool stands(std::span<const Block> stack);

}  // namespace haptics::eval

#pragma once

#include <vector>

#include "tests/eval/random.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::eval {

/// A part of a floor whose top is the plane z = 0, in the floor's frame.
struct Tile {
  shapes::Shape shape;
  Pose pose;
};

/// What is stroked. Its top, away from the rim, is one plane: the exact place of an IHIP is right above the HIP.
struct Floor {
  double scale = 1;           ///< Of a floor of some 0.1 m.
  std::vector<Tile> tiles;    ///< Objects.
  Vec3 low{0}, high{0};       ///< Of the top; z is 0.
  std::vector<double> seams;  ///< x.
};

/// Two to six boxes by one to three, objects side by side by their decimal sizes. Some are meshed in another frame, so that
/// their tops are level but for the rounding of their vertices.
[[nodiscard]] Floor flushBoxes(double scale, Random& random);
/// One mesh, as an import of it leaves it, with a crack that is narrower than the skin: boxes beside one another, an open
/// sheet in two patches, or a block whose top comes in two patches.
[[nodiscard]] Floor crackedMesh(double scale, Random& random);
/// Five boxes so far apart, or in one another where it is negative, m.
[[nodiscard]] Floor fiveBoxes(double width_m, double gap_m);
/// A block of 0.1 m without its top, which is two patches of 4 x 4 squares so far apart; or these alone. As imported.
[[nodiscard]] Floor patchedBlock(double gap_m, bool closed);

}  // namespace haptics::eval

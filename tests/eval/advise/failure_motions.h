#pragma once

#include <string>
#include <vector>

#include "tests/eval/advise/strokes.h"

namespace haptics::eval {

/// What a motion came to in which methods of rendering leave the IHIP inside a body.
struct FailureMotion {
  std::string name;       ///< "pressed through".
  int insideTicks = 0;    ///< In which the IHIP was within the object.
  int longestInside = 0;  ///< Of them in a row; a single one is put right by the next tick.
  double deepestInside_mm = 0;

  [[nodiscard]] bool holds() const noexcept { return longestInside <= 1; }
};

/// Tries an object of the user's scene: pressed through from above at the middle of each stroke, pushed at its sharpest
/// corner as far as its middle, both at 0.5 m/s and back again, and stroked at 2 m/s; 1 kHz, at places that no force
/// moves. Whether the IHIP is inside is judged by winding numbers, which share no code with the contact core and take time
/// in proportion to the object's triangles.
/// @param scene  At rest; with the object, and what may lie in the way.
/// @return None where the object has no inside: an open mesh.
[[nodiscard]] std::vector<FailureMotion> failureMotionsOf(const ServoScene& scene, const LoadedObject& object,
                                                          const std::vector<HandStroke>& strokes);

}  // namespace haptics::eval

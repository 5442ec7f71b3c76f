#pragma once

#include "common/maths/vec.h"

namespace haptics {

/// As a vertex is stored. Whatever goes on with the result goes on with the floats: GCC 12's vectorizer of straight-line
/// code leaves the rounding out where it sees them widened again, and places would differ from those on the other side.
[[nodiscard]] inline Vec3f narrowed(Vec3 v) noexcept {
  Vec3f floats(v);
  asm("" : "+x"(floats.x), "+x"(floats.y), "+x"(floats.z));
  return floats;
}

}  // namespace haptics

#pragma once

#include <array>

#include "common/maths/vec.h"

namespace haptics {

/// A pixel of the window, from its lower left corner.
using Pixel = std::array<int, 2>;

/// A place on the surface as it is drawn: bumps, dents and lattices included. World frame.
struct SurfacePoint {
  Vec3 position{0};  ///< Metres.
  Vec3 normal{0};    ///< Unit, towards the eye; the mean over some pixels.
};

}  // namespace haptics

#pragma once

#include <span>

#include "common/maths/vec.h"

namespace haptics {

/// Where a perspective camera stands. World frame, metres, radians.
struct CameraPlace {
  Vec3 position{0, -1, 0};
  Vec3 focus{0, 0, 0};
  Vec3 up{0, 0, 1};

  bool operator==(const CameraPlace&) const = default;
};

/// The part of the picture that the scene may fill, in fractions of it: 0 left/bottom to 1 right/top.
struct PictureArea {
  double left = 0, right = 1, bottom = 0, top = 1;
};

/// The nearest place from which every point is seen inside the area, looking along `direction` (unit, not parallel to
/// z) with z up. `viewAngle_rad` is the vertical opening, `aspect` width / height. Points must not be empty; where
/// they are all at one place the distance is `smallestDistance_m`.
[[nodiscard]] CameraPlace fitCamera(std::span<const Vec3> points, Vec3 direction, double viewAngle_rad, double aspect,
                                    const PictureArea& area, double smallestDistance_m);

}  // namespace haptics

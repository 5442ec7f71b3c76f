#pragma once

#include <optional>

#include "common/maths/vec.h"

namespace haptics {

/// A place in the picture: pixels from its lower left corner.
using PicturePoint = glm::dvec2;

/// How a perspective camera maps the world onto the picture. World frame, metres.
struct PictureCamera {
  Vec3 eye{0};
  Vec3 right{1, 0, 0}, up{0, 0, 1}, into{0, 1, 0};  ///< Unit, right angles between them.
  double pixelWidth = 1e-3;                         ///< Metres, at a depth of 1 m.
  PicturePoint size_px{1, 1};

  /// From the eye through a place in the picture, to a depth of 1 m.
  [[nodiscard]] Vec3 ray(PicturePoint at) const {
    const PicturePoint from = (at - size_px / 2.0) * pixelWidth;
    return into + right * from.x + up * from.y;
  }
  /// Along the line of sight.
  [[nodiscard]] double depth_m(Vec3 place) const { return glm::dot(place - eye, into); }
  /// Nothing: behind the eye.
  [[nodiscard]] std::optional<PicturePoint> project(Vec3 place) const {
    const double depth = depth_m(place);
    if (!(depth > 0)) return std::nullopt;
    const PicturePoint from(glm::dot(place - eye, right), glm::dot(place - eye, up));
    return from / (depth * pixelWidth) + size_px / 2.0;
  }
};

}  // namespace haptics

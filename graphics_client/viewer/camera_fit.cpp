#include "graphics_client/viewer/camera_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptics {
namespace {

/// One axis of the picture (to the right, or up), with the tangents of the angles from the line of sight to both ends
/// of the area. A point at x along the axis and z towards the viewer is inside for a camera at (cx, d) when
/// tanLow (d - z) <= x - cx <= tanHigh (d - z).
struct PictureAxis {
  double tanLow, tanHigh;
  double low = std::numeric_limits<double>::infinity();    ///< Smallest x + tanLow z.
  double high = -std::numeric_limits<double>::infinity();  ///< Largest x + tanHigh z.

  void add(double x, double z) {
    low = std::min(low, x + tanLow * z);
    high = std::max(high, x + tanHigh * z);
  }
  /// The smallest d for which some cx holds every point: high - tanHigh d <= cx <= low - tanLow d.
  [[nodiscard]] double distance() const { return (high - low) / (tanHigh - tanLow); }
  /// The middle of the cx that hold every point from d.
  [[nodiscard]] double centre(double d) const { return ((high - tanHigh * d) + (low - tanLow * d)) / 2; }
};

}  // namespace

CameraPlace fitCamera(std::span<const Vec3> points, Vec3 direction, double viewAngle_rad, double aspect,
                      const PictureArea& area, double smallestDistance_m) {
  const Vec3 right = glm::normalize(glm::cross(direction, Vec3(0, 0, 1)));
  const Vec3 up = glm::cross(right, direction);
  const double tanVertical = std::tan(viewAngle_rad / 2), tanHorizontal = tanVertical * aspect;
  PictureAxis horizontal{.tanLow = (2 * area.left - 1) * tanHorizontal,
                         .tanHigh = (2 * area.right - 1) * tanHorizontal};
  PictureAxis vertical{.tanLow = (2 * area.bottom - 1) * tanVertical, .tanHigh = (2 * area.top - 1) * tanVertical};
  double nearest = -std::numeric_limits<double>::infinity(), farthest = -nearest;
  for (const Vec3& p : points) {
    const double towards = -glm::dot(p, direction);
    horizontal.add(glm::dot(p, right), towards);
    vertical.add(glm::dot(p, up), towards);
    nearest = std::max(nearest, towards);
    farthest = std::min(farthest, towards);
  }
  const double d = std::max({horizontal.distance(), vertical.distance(), nearest + smallestDistance_m});
  CameraPlace place;
  place.position = right * horizontal.centre(d) + up * vertical.centre(d) - direction * d;
  place.focus = place.position + direction * (d - (nearest + farthest) / 2);
  return place;
}

}  // namespace haptics

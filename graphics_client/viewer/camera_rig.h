#pragma once

#include <vtkCamera.h>

#include <span>

#include "common/maths/vec.h"
#include "common/telemetry/telemetry_sample.h"
#include "graphics_client/viewer/camera_fit.h"
#include "graphics_client/viewer/picture_camera.h"
#include "graphics_client/viewer/render_window.h"

namespace haptics {

/// Places the cameras of the world and of the close-up.
class CameraRig {
 public:
  /// The first look: from the front, a little to the right and above, so that three sides of a box are seen.
  inline static const Vec3 kFirstDirection = glm::normalize(Vec3(-0.26, 1.0, -0.66));

  explicit CameraRig(RenderWindow& renderWindow) : renderWindow_(renderWindow) {}

  /// From where the world is seen, and the place that is orbited around, world frame; z is up.
  struct Look {
    Vec3 eye{0, -1, 0}, focus{0};
    bool operator==(const Look&) const = default;
  };
  [[nodiscard]] Look look();
  /// @param look  Its eye and focus differ.
  void lookAs(const Look& look);

  /// A three-quarter view from the front that shows all the points (world frame) in one of those parts of the picture,
  /// the one where they are larger.
  /// @param direction  Of the look, unit; not quite vertical.
  void frame(std::span<const Vec3> points, std::span<const PictureArea> areas, Vec3 direction = kFirstDirection);
  /// Moves with the contact, keeping direction and distance.
  void setFollow(bool on) { follow_ = on; }

  /// Around the focus with z up, along the picture, towards the focus: as far as a pointer went, in pixels.
  void orbit(double right_px, double up_px);
  void pan(double right_px, double up_px);
  /// @param factor  > 1: nearer.
  void zoom(double factor);

  /// Once a frame, after the actors were placed. `dt_s` since the last one; no sample: the cameras stay.
  void update(const TelemetrySample* sample, double dt_s);

  /// Where the ray of a pixel (from the lower left corner) meets the plane of the picture through a place, world frame.
  [[nodiscard]] Vec3 onPictureThrough(Vec3 place, double x_px, double y_px);
  /// Of the world.
  [[nodiscard]] PictureCamera picture();
  /// From the eye into the picture, unit.
  [[nodiscard]] Vec3 direction();
  /// Scale of the world's camera at a point, and of the close-up's at its centre.
  [[nodiscard]] double worldMetresPerPixel(Vec3 place);
  [[nodiscard]] double closeUpMetresPerPixel();
  [[nodiscard]] Vec3 worldPosition();
  [[nodiscard]] Vec3 closeUpPosition();

 private:
  RenderWindow& renderWindow_;
  bool follow_ = false;
  bool seen_ = false;
  Vec3 centre_{0}, normal_{0, 0, 1};  // of the close-up, smoothed

  void follow(Vec3 place, double dt_s);
  void clip(const double bounds[6]);
  void aimCloseUp(const TelemetrySample& sample, double dt_s);
};

}  // namespace haptics

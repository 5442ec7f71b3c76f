#pragma once

#include <optional>

#include "common/telemetry/hand_command.h"
#include "graphics_client/viewer/surface_point.h"

namespace haptics {

/// Where a pointer on the screen leads the simulated hand. Two mappings:
///   - on the surface: the hand strokes the surface under the pointer and presses with a set force; with the button up it
///     lifts;
///   - in space: it moves in the plane of the picture through the hand, and the wheel moves it towards and away.
class HandSteering {
 public:
  enum class Mapping { kSurface, kSpace };
  static constexpr double kMinPress_N = 0.2, kMaxPress_N = 5;
  static constexpr double kHover_m = 0.015;  ///< Of a lifted hand, above the surface.

  /// Of one frame. World frame.
  struct Pointer {
    bool pressed = false;
    std::optional<SurfacePoint> surface;  ///< Of an object, under the pointer.
    Vec3 onPicture{0};                    ///< Under the pointer, in the plane of the picture through `hand()`.
    Vec3 eye{0};                          ///< Where the picture is seen from.
  };

  void setMapping(Mapping mapping) { mapping_ = mapping; }
  [[nodiscard]] Mapping mapping() const { return mapping_; }
  /// Newtons; clamped to what there is.
  void setPress_N(double press_N);
  /// By a fifth for each click of a wheel.
  void changePress(double clicks);
  [[nodiscard]] double press_N() const { return press_N_; }
  /// In space: along the line of sight.
  void moveBy(Vec3 way_m) { hand_ += way_m; }
  /// How it is held, of a device that senses it: turned on, about a world axis.
  void turnBy(const Quat& turn) { rotation_ = glm::normalize(turn * rotation_); }
  /// By 2 degrees for each click of a wheel, of a device that has a gripper. Turned back, it goes from where the gripper is.
  /// @param now_rad  Its opening, as last heard.
  void openGripper(double clicks, double now_rad);
  /// The hand is led from here on.
  void begin(Vec3 hip);

  /// The command of this frame.
  /// @param hip  Where the device has the hand, as last heard.
  [[nodiscard]] HandCommand next(const Pointer& pointer, Vec3 hip, double dt_s);
  /// Of the last command, without what it presses.
  [[nodiscard]] Vec3 hand() const { return hand_; }

 private:
  Mapping mapping_ = Mapping::kSurface;
  double press_N_ = 1;
  Vec3 hand_{0};
  Quat rotation_{1, 0, 0, 0};
  std::optional<double> gripper_rad_;
  Vec3 normal_{0, 0, 1};  // smoothed
  Vec3 place_{0};         // on the surface, last
  double clearance_m_ = kHover_m;
  bool wasPressed_ = false, touched_ = false;
  Vec3 grabbedAt_{0};  // in space: from the pointer to the hand

  [[nodiscard]] HandCommand onSurface(const Pointer& pointer, Vec3 hip, double dt_s);
  [[nodiscard]] HandCommand inSpace(const Pointer& pointer);
};

}  // namespace haptics

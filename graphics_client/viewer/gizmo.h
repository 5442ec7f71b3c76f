#pragma once

#include <optional>

#include "common/maths/vec.h"
#include "graphics_client/viewer/picture_camera.h"

// Handles about an object by which a pointer moves and turns it: an arrow along each axis of the world, a ring about each.
// World frame, metres, radians.
namespace haptics {

struct GizmoHandle {
  enum class Kind { kMove, kTurn };
  Kind kind = Kind::kMove;
  int axis = 0;  ///< 0 x, 1 y, 2 z.

  bool operator==(const GizmoHandle&) const = default;
};

/// Which of them there are.
struct GizmoHandles {
  bool moves = true, turns = true;
  bool operator==(const GizmoHandles&) const = default;
};

/// The handles as a camera sees them; their size in the picture is the same everywhere.
class Gizmo {
 public:
  /// Of an arrow, from `kArrowStart_px` to `kArrow_px` of the centre, and the radius of a ring; seen from in front.
  static constexpr double kArrowStart_px = 16, kArrow_px = 100, kRing_px = 68;
  /// So near a handle the pointer is on it.
  static constexpr double kReach_px = 8;

  Gizmo(const PictureCamera& camera, Vec3 centre, GizmoHandles handles = {});

  [[nodiscard]] Vec3 centre() const { return centre_; }
  /// Of a pixel at the centre.
  [[nodiscard]] double metresPerPixel() const { return metresPerPixel_; }
  /// An arrow along the line of sight is not: it could not be dragged.
  [[nodiscard]] bool isShown(const GizmoHandle& handle) const;
  /// The nearest handle that the pointer is on.
  [[nodiscard]] std::optional<GizmoHandle> handleAt(PicturePoint pointer) const;

 private:
  PictureCamera camera_;
  Vec3 centre_;
  GizmoHandles handles_;
  double metresPerPixel_;

  [[nodiscard]] double distance_px(const GizmoHandle& handle, PicturePoint pointer) const;
};

/// An object that is dragged by a handle, from the press of the button until it is let go of.
class GizmoDrag {
 public:
  /// @param pose  Of the object.
  GizmoDrag(const GizmoHandle& handle, const Gizmo& gizmo, const Pose& pose, const PictureCamera& camera,
            PicturePoint pointer);

  /// Where the object is with the pointer there. Where the pointer says nothing, as beyond the horizon of the axis, it stays.
  [[nodiscard]] Pose moveTo(const PictureCamera& camera, PicturePoint pointer);
  [[nodiscard]] const GizmoHandle& handle() const { return handle_; }
  /// Of the gizmo, which goes with the object.
  [[nodiscard]] Vec3 centre() const;

 private:
  GizmoHandle handle_;
  Vec3 centre_, axis_;
  Pose pose_;
  Vec3 line_{0}, along_{0};         // what the pointer is projected onto: the axis, or a tangent of a ring seen edge-on
  std::optional<double> radius_m_;  // of that ring
  std::optional<double> begin_, now_;  // on the line (m), or the angle on the ring (rad), as last known

  [[nodiscard]] std::optional<double> angleOf(const PictureCamera& camera, PicturePoint pointer) const;
};

/// How far along a line (unit direction) its place nearest to a ray through the picture is. Nothing: they run alike, or the
/// place is behind the eye.
[[nodiscard]] std::optional<double> nearestOnLine(Vec3 start, Vec3 along, const PictureCamera& camera,
                                                  PicturePoint pointer);

}  // namespace haptics

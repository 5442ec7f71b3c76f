#pragma once

#include "common/maths/vec.h"
#include "haptic_server/engine/contact/frame.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// One object as the contact core sees it in a tick. The step sets all but what is derived and calls update(), before
/// followContact(); metres, world frame.
struct Body {
  const CollisionMesh* surface = nullptr;
  Pose previous;                ///< At the last tick.
  Pose current;                 ///< At this tick.
  bool pendingRemoval = false;  ///< Cannot be touched anew; a contact that holds goes on.

  bool deforming = false;  ///< Its vertices have moved since the last tick, near the IHIP:
  Vec3 shift{0};           ///< so much where that was then, as surfaceShift() says; body frame.

  bool moving = false;  ///< Derived: previous != current, or it is deforming.
  Frame frame{Pose{}};  ///< Derived: `current`.
  double extent_m = 0;  ///< Derived: largest coordinate that it brings into the world.
  Vec3 centre{0};       ///< Derived: of the bounding sphere, at `current`.

  void update() noexcept {
    moving = deforming || !(previous == current);
    frame = Frame(current);
    extent_m = surface->extent_m() + glm::length(current.position);
    centre = frame.toWorld(surface->centre());
  }
};

/// Is a place (world, metres) within the sphere about the body?
[[nodiscard]] inline bool withinSphere(const Body& body, Vec3 place) noexcept {
  const double radius = body.surface->radius_m();
  return squaredLength(place - body.centre) <= radius * radius;
}

}  // namespace haptics

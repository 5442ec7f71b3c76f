#pragma once

#include "common/maths/vec.h"

namespace haptics {

/// A pose with its rotation as a matrix, which turns a vector at less than half of what a quaternion costs. Metres.
struct Frame {
  Vec3 x;  ///< The frame's own axes, in the world.
  Vec3 y;
  Vec3 z;
  Vec3 origin;  ///< World.

  Frame() = default;  ///< Not initialised.
  explicit Frame(const Pose& pose) noexcept
      : x(pose.rotation * Vec3(1, 0, 0)),
        y(pose.rotation * Vec3(0, 1, 0)),
        z(pose.rotation * Vec3(0, 0, 1)),
        origin(pose.position) {}

  /// A direction in world coordinates.
  [[nodiscard]] Vec3 rotate(Vec3 local) const noexcept { return x * local.x + y * local.y + z * local.z; }
  [[nodiscard]] Vec3 toWorld(Vec3 local) const noexcept { return rotate(local) + origin; }
  [[nodiscard, gnu::always_inline]] Vec3 toLocal(Vec3 world) const noexcept { return toLocalDirection(world - origin); }
  /// Of a direction in world coordinates.
  [[nodiscard, gnu::always_inline]] Vec3 toLocalDirection(Vec3 world) const noexcept {
    return {glm::dot(x, world), glm::dot(y, world), glm::dot(z, world)};
  }
};

}  // namespace haptics

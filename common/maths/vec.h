#pragma once

#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "common/maths/fields.h"

namespace haptics {

using Vec3 = glm::dvec3;  ///< Everything that is computed.
using Vec3f = glm::vec3;  ///< Vertices as stored: these floats *are* the surface.
using Quat = glm::dquat;  ///< Unit quaternion; constructor order w, x, y, z.

/// Object frame to world: x_world = rotation * x_object + position (metres).
struct Pose {
  Quat rotation{1, 0, 0, 0};
  Vec3 position{0, 0, 0};

  bool operator==(const Pose&) const = default;
  HAPTICS_FIELDS(self.rotation, self.position);
};

[[nodiscard]] inline Vec3 toWorld(const Pose& pose, Vec3 local) noexcept {
  return pose.rotation * local + pose.position;
}

[[nodiscard]] inline Vec3 toLocal(const Pose& pose, Vec3 world) noexcept {
  return glm::conjugate(pose.rotation) * (world - pose.position);
}

/// The pose at fraction s of the way from a to b: normalised linear interpolation along the shorter arc.
[[nodiscard]] inline Pose interpolate(const Pose& a, const Pose& b, double s) noexcept {
  const double towards = glm::dot(a.rotation, b.rotation) < 0 ? -s : s;
  return {glm::normalize(a.rotation * (1 - s) + b.rotation * towards), glm::mix(a.position, b.position, s)};
}

[[nodiscard]] inline double squaredLength(Vec3 v) noexcept { return glm::dot(v, v); }

[[nodiscard]] inline bool isFinite(Vec3 v) noexcept {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

[[nodiscard]] inline bool isFinite(const Pose& p) noexcept {
  return isFinite(p.position) && std::isfinite(p.rotation.w) && isFinite({p.rotation.x, p.rotation.y, p.rotation.z});
}

}  // namespace haptics

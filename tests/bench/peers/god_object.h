#pragma once

#include <array>
#include <cmath>

#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics::bench {

/// Zilles and Salisbury's god-object on the production hierarchy, for one body at rest: every tick moves by segment
/// tests against the whole mesh, none by neighbours. Nothing but what the method needs, to show its speed; tests/eval
/// has the one that shows its accuracy.
class GodObject {
 public:
  GodObject(const CollisionMesh& surface, Vec3 outside) : surface_(surface), god_(outside) {}

  /// Returns the god-object's place (body frame, metres) for the HIP at h.
  Vec3 tick(Vec3 h) noexcept {
    move(h);
    return god_;
  }

 private:
  static constexpr std::size_t kMaxPlanes = 3;
  static constexpr double kSkin = 0x1p-20;  // of the extent, that the god-object stays above its planes

  /// Towards the HIP, along the planes that are met on the way.
  void move(Vec3 h) noexcept {
    std::size_t planes = 0;
    std::array<Vec3, kMaxPlanes> axis;  // orthonormal: of the normals met
    Vec3 goal = h;
    while (true) {
      const Crossing crossing = surface_.firstCrossing(god_, goal);
      if (!crossing) {
        god_ = goal;
        return;
      }
      if (planes == kMaxPlanes) return;
      const TriangleRecord& r = surface_.triangle(crossing.triangle);
      const Vec3 normal = unitOrZero(r.areaNormal());
      const double gap = glm::dot(normal, r.corner(0) - goal) + kSkin * surface_.extent_m();
      Vec3 free = normal;
      for (std::size_t i = 0; i < planes; ++i) free -= axis[i] * glm::dot(free, axis[i]);
      const double free2 = squaredLength(free);
      if (free2 == 0) return;
      goal += free * (gap / free2);
      axis[planes++] = free / std::sqrt(free2);
    }
  }

  const CollisionMesh& surface_;
  Vec3 god_;
};

}  // namespace haptics::bench

#pragma once

#include <algorithm>

#include "common/mesh/generators.h"
#include "haptic_server/engine/collision/collision_points.h"
#include "tests/eval/moving_world.h"

/// What scenes of bodies that meet are put together of.
namespace haptics::eval::put_bodies {

inline constexpr Vec3 kGravity{0, 0, -9.81};
inline constexpr Vec3 kFarAway{0, 0, 1};

[[nodiscard]] inline TriMesh boxMesh(Vec3 size_m) { return makeBox(size_m, 1).value(); }
[[nodiscard]] inline Pose at(Vec3 position) { return {{1, 0, 0, 0}, position}; }

/// A body that meets others; one of no mass is fixed.
inline std::uint64_t add(BodyWorld& world, const TriMesh& mesh, double mass_kg, const Pose& pose, Vec3 gravity_m_per_s2,
                         bool slips = false) {
  MovingSolid solid = solidFrom(mesh, std::max(mass_kg, 1e-3));
  solid.body.gravity_m_per_s2 = gravity_m_per_s2;
  const std::uint64_t id = world.add(solid, pose, mass_kg > 0);
  CollisionPoints points = makeCollisionPoints(*solid.surface);
  if (slips) points.friction = points.rolling_m = 0;
  world.object(id).collision = std::make_shared<const CollisionPoints>(std::move(points));
  return id;
}

/// Its top at z = 0.
inline std::uint64_t addTable(BodyWorld& world) {
  return add(world, boxMesh({0.5, 0.5, 0.02}), 0, at({0, 0, -0.01}), Vec3(0));
}

}  // namespace haptics::eval::put_bodies

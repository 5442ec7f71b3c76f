#pragma once

#include <numbers>
#include <stdexcept>

#include "common/mesh/generators.h"
#include "haptic_server/engine/motion/rigid_motion.h"
#include "haptic_server/engine/motion/solid.h"
#include "haptic_server/engine/motion/support_points.h"

namespace haptics::test {

inline constexpr double kPeriod_s = 1e-3;
inline constexpr double kPi = std::numbers::pi;

/// A body of a mesh, of this mass.
inline RigidBody bodyOf(const TriMesh& mesh, double mass_kg) {
  const Solid solid = solidOf(mesh.vertices, mesh.triangles);
  RigidBody body;
  const MassDefect defect = spreadMass(mass_kg, solid.centre, mass_kg / solid.volume_m3 * solid.inertia, body.mass);
  if (solid.defect != SolidDefect::kNone || defect != MassDefect::kNone) throw std::logic_error("not a body");
  body.setSupport(supportPoints(mesh.vertices));
  return body;
}

inline RigidBody boxOf(Vec3 size_m, double mass_kg) { return bodyOf(makeBox(size_m, 2).value(), mass_kg); }

/// Far from everything.
inline RigidBody floating(RigidBody body) {
  body.gravity_m_per_s2 = Vec3(0);
  return body;
}

/// A body and where it is.
struct Moving {
  RigidBody body;
  RigidState state;

  Moving(RigidBody b, const Pose& pose) : body(std::move(b)), state(restingAt(body, pose)) {}
  void tick(const Push& push = {}) {
    MotionAllowance endless;
    moveRigidBody(body, state, push, kPeriod_s, endless);
  }
  void run(double seconds, const Push& push = {}) {
    for (int i = 0; i < std::lround(seconds / kPeriod_s); ++i) tick(push);
  }
  [[nodiscard]] Pose pose() const { return poseOf(body, state); }
  [[nodiscard]] RigidVelocity velocity() const { return velocityOf(body, state); }
  [[nodiscard]] double energy() const { return energyOf(body, state); }
};

}  // namespace haptics::test

#include "haptic_server/engine/motion/rigid_body.h"

#include <algorithm>

#include "common/maths/rotation.h"
#include "haptic_server/engine/motion/joint_motion.h"

namespace haptics {

void RigidBody::setSupport(const std::vector<Vec3>& points) {
  support.clear();
  radius_m = 0;
  for (const Vec3 p : points) {
    support.push_back(glm::conjugate(mass.principal) * (p - mass.centre));
    radius_m = std::max(radius_m, glm::length(support.back()));
  }
}

RigidState restingAt(const RigidBody& body, const Pose& pose) noexcept {
  RigidState state;
  state.rest = state.still = pose;
  state.centre_m = toWorld(pose, body.mass.centre);
  state.axes = glm::normalize(pose.rotation * body.mass.principal);
  return state;
}

Pose poseOf(const RigidBody& body, const RigidState& state) noexcept {
  if (body.freedom != Freedom::kFree) return jointPose(body, state);
  const Quat rotation = glm::normalize(state.axes * glm::conjugate(body.mass.principal));
  return {rotation, state.centre_m - rotation * body.mass.centre};
}

RigidVelocity velocityOf(const RigidBody& body, const RigidState& state) noexcept {
  if (body.freedom != Freedom::kFree) return jointVelocity(body, state);
  return {state.momentum_Ns / body.mass.mass_kg, angularVelocity(body.mass, state.axes, state.angularMomentum_Nms)};
}

double energyOf(const RigidBody& body, const RigidState& state) noexcept {
  const Pose pose = poseOf(body, state);
  const RigidVelocity v = velocityOf(body, state);
  const Vec3 centre = toWorld(pose, body.mass.centre);
  const Vec3 spin = glm::conjugate(pose.rotation * body.mass.principal) * v.angular;
  const double kinetic =
      0.5 * body.mass.mass_kg * squaredLength(v.linear) + 0.5 * glm::dot(body.mass.moments * spin, spin);
  const double gravity = -body.mass.mass_kg * glm::dot(body.gravity_m_per_s2, centre);

  const PoseSpring& spring = body.spring;
  if (body.freedom == Freedom::kFree) {
    const Vec3 stretch = centre - toWorld(state.rest, body.mass.centre);
    const Vec3 twist = rotationVector(pose.rotation * glm::conjugate(state.rest.rotation));
    return kinetic + gravity + 0.5 * spring.stiffness_N_per_m * squaredLength(stretch) +
           0.5 * spring.stiffness_Nm_per_rad * squaredLength(twist);
  }
  const double stiffness = body.freedom == Freedom::kHinge ? spring.stiffness_Nm_per_rad : spring.stiffness_N_per_m;
  return kinetic + gravity + 0.5 * stiffness * state.coordinate * state.coordinate;
}

}  // namespace haptics

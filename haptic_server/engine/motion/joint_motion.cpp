#include "haptic_server/engine/motion/joint_motion.h"

#include <algorithm>

#include "common/maths/rotation.h"

namespace haptics {
namespace {

/// What a joint makes of body and forces: mass or moment about the axis, force or torque along it.
struct Along {
  double inertia = 0;
  double drive = 0;
  double stiffness = 0;
  double damping = 0;
};

[[nodiscard]] Vec3 worldAxis(const RigidBody& body, const RigidState& state) noexcept {
  return state.rest.rotation * body.joint.axis;
}

[[nodiscard]] Along alongHinge(const RigidBody& body, const RigidState& state, const Push& push) noexcept {
  const MassProperties& mass = body.mass;
  const Vec3 axis = worldAxis(body, state);
  const Vec3 anchor = toWorld(state.rest, body.joint.anchor_m);
  const Vec3 arm = toWorld(jointPose(body, state), mass.centre) - anchor;
  const Vec3 own = glm::conjugate(mass.principal) * body.joint.axis;  // the axis in the principal frame
  const Vec3 torque = glm::cross(arm, mass.mass_kg * body.gravity_m_per_s2) +
                      glm::cross(push.place_m - anchor, push.force_N) + push.torque_Nm;
  return {glm::dot(mass.moments * own, own) + mass.mass_kg * squaredLength(glm::cross(axis, arm)),
          glm::dot(axis, torque), body.spring.stiffness_Nm_per_rad, body.spring.damping_Nms_per_rad};
}

[[nodiscard]] Along alongSlider(const RigidBody& body, const RigidState& state, const Push& push) noexcept {
  const double mass = body.mass.mass_kg;
  return {mass, glm::dot(worldAxis(body, state), mass * body.gravity_m_per_s2 + push.force_N),
          body.spring.stiffness_N_per_m, body.spring.damping_Ns_per_m};
}

}  // namespace

void driveOnJoint(const RigidBody& body, RigidState& state, const Push& push, double period_s) noexcept {
  const bool hinge = body.freedom == Freedom::kHinge;
  const Along a = hinge ? alongHinge(body, state, push) : alongSlider(body, state, push);
  const double stiffness = std::min(a.stiffness, a.inertia / (period_s * period_s));
  const double fading = (hinge ? body.angularDamping_per_s : body.linearDamping_per_s) + a.damping / a.inertia;

  state.rate_per_s += period_s * (a.drive - stiffness * state.coordinate) / a.inertia;
  state.rate_per_s /= 1 + period_s * fading;  // implicit: no damping is too much
}

void advanceOnJoint(const RigidBody& body, RigidState& state, double period_s) noexcept {
  state.coordinate += period_s * state.rate_per_s;
  if (state.coordinate < body.joint.lowest) {
    state.coordinate = body.joint.lowest;
    state.rate_per_s = std::max(state.rate_per_s, 0.0);
  } else if (state.coordinate > body.joint.highest) {
    state.coordinate = body.joint.highest;
    state.rate_per_s = std::min(state.rate_per_s, 0.0);
  }
}

double inertiaOnJoint(const RigidBody& body, const RigidState& state) noexcept {
  return body.freedom == Freedom::kHinge ? alongHinge(body, state, {}).inertia : body.mass.mass_kg;
}

Vec3 directionOnJoint(const RigidBody& body, const RigidState& state, Vec3 place_m) noexcept {
  const Vec3 axis = worldAxis(body, state);
  if (body.freedom == Freedom::kSlider) return axis;
  return glm::cross(axis, place_m - toWorld(state.rest, body.joint.anchor_m));
}

Pose jointPose(const RigidBody& body, const RigidState& state) noexcept {
  const Vec3 axis = worldAxis(body, state);
  if (body.freedom == Freedom::kSlider) return {state.rest.rotation, state.rest.position + state.coordinate * axis};
  const Vec3 anchor = toWorld(state.rest, body.joint.anchor_m);
  const Quat turn = rotationBy(state.coordinate * axis);
  return {glm::normalize(turn * state.rest.rotation), anchor + turn * (state.rest.position - anchor)};
}

RigidVelocity jointVelocity(const RigidBody& body, const RigidState& state) noexcept {
  const Vec3 along = state.rate_per_s * worldAxis(body, state);
  if (body.freedom == Freedom::kSlider) return {along, Vec3(0)};
  const Vec3 arm = toWorld(jointPose(body, state), body.mass.centre) - toWorld(state.rest, body.joint.anchor_m);
  return {glm::cross(along, arm), along};
}

}  // namespace haptics

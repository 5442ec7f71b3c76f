#include "haptic_server/engine/motion/rigid_motion.h"

#include <algorithm>

#include "common/maths/rotation.h"
#include "haptic_server/engine/motion/joint_motion.h"
#include "haptic_server/engine/motion/plane_contacts.h"

namespace haptics {
namespace {

[[nodiscard]] bool isFinite(const RigidState& s) noexcept {
  return haptics::isFinite(Pose{s.axes, s.centre_m}) && haptics::isFinite(s.momentum_Ns) &&
         haptics::isFinite(s.angularMomentum_Nms) && std::isfinite(s.coordinate) && std::isfinite(s.rate_per_s);
}

/// Momentum of everything but the planes; then damping.
void drive(const RigidBody& body, RigidState& state, const Push& push, double period_s) noexcept {
  const MassProperties& mass = body.mass;
  const PoseSpring& spring = body.spring;
  Vec3 force = mass.mass_kg * body.gravity_m_per_s2 + push.force_N;
  Vec3 torque = glm::cross(push.place_m - state.centre_m, push.force_N) + push.torque_Nm;
  const double perTick2 = 1 / (period_s * period_s);
  if (spring.stiffness_N_per_m > 0) {
    const double stiffness = std::min(spring.stiffness_N_per_m, mass.mass_kg * perTick2);
    force -= stiffness * (state.centre_m - toWorld(state.rest, mass.centre));
  }
  if (spring.stiffness_Nm_per_rad > 0) {
    const double least = std::min({mass.moments.x, mass.moments.y, mass.moments.z});
    const double stiffness = std::min(spring.stiffness_Nm_per_rad, least * perTick2);
    torque -= stiffness * rotationVector(state.axes * glm::conjugate(state.rest.rotation * mass.principal));
  }
  state.momentum_Ns += period_s * force;
  state.angularMomentum_Nms += period_s * torque;

  state.momentum_Ns /= 1 + period_s * (body.linearDamping_per_s + spring.damping_Ns_per_m / mass.mass_kg);
  state.angularMomentum_Nms /= 1 + period_s * body.angularDamping_per_s;
  if (spring.damping_Nms_per_rad > 0) {
    const Vec3 own = glm::conjugate(state.axes) * state.angularMomentum_Nms;
    state.angularMomentum_Nms = state.axes * (own / (Vec3(1) + period_s * spring.damping_Nms_per_rad / mass.moments));
  }
}

void turnAndMove(const RigidBody& body, RigidState& state, double period_s) noexcept {
  state.centre_m += period_s / body.mass.mass_kg * state.momentum_Ns;
  if (state.angularMomentum_Nms == Vec3(0)) return;
  const Vec3 first = angularVelocity(body.mass, state.axes, state.angularMomentum_Nms);
  const Quat midway = rotationBy(0.5 * period_s * first) * state.axes;
  const Vec3 middle = angularVelocity(body.mass, midway, state.angularMomentum_Nms);
  state.axes = glm::normalize(rotationBy(period_s * middle) * state.axes);
}

/// How far the farthest point of a body of this radius is from where another pose has it, m; at most half too much.
[[nodiscard]] double moved(const Pose& from, const Pose& to, Vec3 centre, double radius_m) noexcept {
  const Quat turn = to.rotation * glm::conjugate(from.rotation);
  return glm::distance(toWorld(from, centre), toWorld(to, centre)) +
         2 * radius_m * glm::length(Vec3(turn.x, turn.y, turn.z));
}

/// Units (Allowance) of a motion, planes apart.
constexpr std::int64_t kMotion = 1'200;

}  // namespace

void stop(RigidState& state, BodyCondition why) noexcept {
  state.momentum_Ns = state.angularMomentum_Nms = Vec3(0);
  state.rate_per_s = 0;
  state.condition = why;
}

void driveRigidBody(const RigidBody& body, RigidState& state, const Push& push, double period_s) noexcept {
  if (body.freedom == Freedom::kFree) {
    drive(body, state, push, period_s);
  } else {
    driveOnJoint(body, state, push, period_s);
  }
}

void advanceRigidBody(const RigidBody& body, RigidState& state, double period_s) noexcept {
  if (body.freedom == Freedom::kFree) {
    turnAndMove(body, state, period_s);
  } else {
    advanceOnJoint(body, state, period_s);
  }
}

bool keepInWorld(const RigidBody& body, RigidState& state, const RigidPlace& before) noexcept {
  const bool finite = isFinite(state);
  if (finite && squaredLength(poseOf(body, state).position) <= kWorldRadius_m * kWorldRadius_m) return true;
  state.centre_m = before.centre_m;
  state.axes = before.axes;
  state.coordinate = before.coordinate;
  stop(state, finite ? BodyCondition::kOutOfBounds : BodyCondition::kNonFinite);
  return false;
}

bool isStill(const RigidBody& body, RigidState& state, const Push& push, double period_s) noexcept {
  const Pose pose = poseOf(body, state);
  const Vec3 m = body.mass.moments;
  const double gyration = std::sqrt((m.x + m.y + m.z) / body.mass.mass_kg);
  if (push.any() || moved(state.still, pose, body.mass.centre, std::max(body.radius_m, gyration)) > kStill_m) {
    state.still = pose;
    state.still_s = 0;
    return false;
  }
  state.still_s += period_s;
  return state.still_s >= kStill_s;
}

std::int64_t leastMotionUnits(const RigidBody& body, const RigidState& state) noexcept {
  return kMotion + (body.freedom == Freedom::kFree ? leastPlaneUnits(body, state) : 0);
}

void moveRigidBody(const RigidBody& body, RigidState& state, const Push& push, double period_s,
                   MotionAllowance& allowance) noexcept {
  allowance.least.spend(kMotion);
  if (state.condition == BodyCondition::kAsleep && push.any()) state.condition = BodyCondition::kAwake;
  if (state.condition != BodyCondition::kAwake) return;

  const RigidPlace before = placeOf(state);
  driveRigidBody(body, state, push, period_s);
  if (body.freedom == Freedom::kFree) solvePlaneContacts(body, state, period_s, allowance);
  advanceRigidBody(body, state, period_s);
  if (body.freedom == Freedom::kFree) leavePlanes(body, state);
  if (keepInWorld(body, state, before) && isStill(body, state, push, period_s)) stop(state, BodyCondition::kAsleep);
}

}  // namespace haptics

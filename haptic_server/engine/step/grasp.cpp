#include "haptic_server/engine/step/grasp.h"

#include <algorithm>
#include <cmath>

#include "common/maths/rotation.h"
#include "haptic_server/engine/step/edited_objects.h"

namespace haptics {
namespace {

/// By which a body turned in a tick; world, rad/s.
[[nodiscard]] Vec3 rateOf(Quat before, Quat after, double period_s) noexcept {
  return rotationVector(after * glm::conjugate(before)) / period_s;
}

void take(HapticState& state, const DevicePose& device) noexcept {
  const auto holding = state.contact.surfaces();
  if (holding.empty() || state.features.tool || !isRotation(device.rotation)) return;
  const auto body = static_cast<std::size_t>(holding[0].body);
  const auto all = state.moving.all();
  const auto moving = std::ranges::find(all, body, &MovingBody::body);
  const ObjectState& object = state.objects[body];
  if (moving == all.end() || object.id != state.report.object || object.pendingRemoval || object.beingMoved) return;
  state.grasp.object = object.id;
  state.grasp.moving = static_cast<std::uint64_t>(moving - all.begin());
  state.grasp.place = toLocal(state.bodies[body].previous, state.contact.ihip);
  state.grasp.device = device.rotation;
  state.grasp.turned = glm::conjugate(device.rotation) * state.bodies[body].current.rotation;
  state.tool.torque.reset(device.rotation);
  state.features.torqueFades = true;
  state.surface.forget();
  state.groove.shaded = false;
  state.release();
  state.limits.slew.begin();
  state.now.contactBroken = true;
}

}  // namespace

void letGo(HapticState& state) noexcept {
  state.grasp.object = 0;
  state.graspTorque_Nm = Vec3(0);
  resetContact(state.contact, state.estimate.hip);
  state.limits.slew.begin();
  state.now.contactBroken = true;
}

bool followGrasp(HapticState& state, const DevicePose& device) noexcept {
  const bool wasPressed = state.grasp.pressed, pressed = device.status.does(HandAction::kGrasp);
  state.grasp.pressed = pressed;
  if (state.grasp.object != 0) {
    if (!pressed || isStopped(state.moving[state.grasp.moving].state.condition)) letGo(state);
  } else if (pressed && !wasPressed) {
    take(state, device);
  }
  if (!pressed) {
    state.features.grasp = false;
    state.features.extras = state.hasExtras();
  }
  return state.grasp.object != 0;
}

void feelGrasp(const ServoScene& scene, HapticState& state, const StepConfig& config, const DevicePose& device,
               ForceResult& result) noexcept {
  Grasp& grasp = state.grasp;
  const MovingBody& moving = state.moving[grasp.moving];
  const std::size_t index = moving.body;
  const ServoObject& object = scene.objects[index];
  const Body& body = state.bodies[index];

  const Vec3 held = toWorld(body.current, grasp.place), stretch = held - state.estimate.hip;
  const Vec3 velocity = (held - toWorld(body.previous, grasp.place)) / config.period_s;
  const double depth = glm::length(stretch);
  const Vec3 direction = depth > 0 ? stretch / depth : Vec3(0);
  const Vec3 relative = velocity - state.estimate.velocity.velocity();
  updateStiffness(scene, state, config, index, depth, -glm::dot(relative, direction));
  const Vec3 spring = state.objects[index].stiffness.value().spring_N_per_m * stretch;
  const Vec3 damping = object.graspDamping_Ns_per_m * relative;
  const double part = writtenFraction(limitMagnitude(spring + damping, config.maxForce_N), spring + damping);
  result.force.spring = part * spring;
  result.force.damping = part * damping;
  result.force.contact = result.force.spring + result.force.damping;

  DeviceTorque& torque = state.tool.torque;
  const Quat turned = torque.follow(isRotation(device.rotation) ? device.rotation : torque.measured());
  const Quat off = body.current.rotation * glm::conjugate(turned * grasp.turned);
  const Vec3 rate = rateOf(body.previous.rotation, body.current.rotation, config.period_s) -
                    rateOf(grasp.device, turned, config.period_s);
  const Vec3 moments = state.rigidBody(moving).mass.moments;
  const double torsion = object.torsion_Nm_per_rad;
  const double damper = std::sqrt(torsion * std::min({moments.x, moments.y, moments.z}));
  state.graspTorque_Nm = 2 * torsion * off.w * Vec3(off.x, off.y, off.z) + damper * rate;
  torque.setTwist(torsion > 0 ? state.graspTorque_Nm / torsion : Vec3(0), torsion);
  grasp.device = turned;

  resetContact(state.contact, held);
  ContactResult& contact = result.contact;
  contact.touching = true;
  contact.body = static_cast<int>(index);
  contact.ihip = held;
  contact.normal = result.geometricNormal = direction;
  contact.penetration_m = depth;
  contact.alongNormal = true;
}

}  // namespace haptics

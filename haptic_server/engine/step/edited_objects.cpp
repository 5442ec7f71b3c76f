#include "haptic_server/engine/step/edited_objects.h"

#include <algorithm>

#include "haptic_server/engine/step/held_springs.h"
#include "haptic_server/engine/step/kinematic_motion.h"
#include "haptic_server/engine/step/rate_limited_pose.h"

namespace haptics {
namespace {

void moveEditedObject(const ServoScene& scene, HapticState& state, const StepConfig& config, std::size_t i) noexcept {
  ObjectState& object = state.objects[i];
  const Body& body = state.bodies[i];
  // There, and the contact has come along: one more tick, at rest.
  object.beingMoved = !(body.current == object.scenePose) || state.contact.reached < 1;
  const Stiffness k = stiffer(object.stiffness.value(), ownStiffness(scene, state, i));
  const RateLimitedPose pose(state.contact.hip, state.contact.ihip, k);
  const Pose previous = lastTestedPose(state, body);
  state.place(i, previous, pose.next(body.current, object.scenePose, config.period_s));
  state.limits.slew.begin();
}

void moveObjects(const ServoScene& scene, HapticState& state, const StepConfig& config) noexcept {
  state.features.beingMoved = false;
  for (std::size_t i = 0; i < state.objects.count; ++i) {
    ObjectState& object = state.objects[i];
    const bool isDriven = state.driven.count > 0 && moveDrivenObject(scene, state, config.period_s, i);
    const bool isEdited = object.beingMoved;
    if (isEdited) moveEditedObject(scene, state, config, i);
    const bool isReshaped = state.reshaped.count > 0 && moveDrivenShape(scene, state, config.period_s, i);
    state.features.beingMoved = state.features.beingMoved || isDriven || isReshaped || object.beingMoved;
    if (!(isDriven || isEdited || isReshaped) || object.id != state.report.object) continue;
    const Body& body = state.bodies[i];
    const Vec3 shift =
        toWorld(body.current, toLocal(body.previous, state.contact.ihip) + body.shift) - state.contact.ihip;
    state.energy.attribute(object.id, isDriven || isReshaped ? EnergyFeature::kMotion : EnergyFeature::kEdit,
                           glm::dot(state.energy.written_N(), shift));
  }
}

void releaseFaded(HapticState& state) noexcept {
  const auto hasFaded = [&](const ContactSurface& held) {
    const auto body = static_cast<std::size_t>(held.body);
    return state.bodies[body].pendingRemoval && state.objects[body].stiffness.value() == Stiffness{};
  };
  if (!std::ranges::any_of(state.contact.surfaces(), hasFaded)) return;
  releaseContact(state.contact);
  state.now.contactBroken = true;
  state.limits.slew.begin();
}

}  // namespace

void updateStiffness(const ServoScene& scene, HapticState& state, const StepConfig& config, std::size_t body,
                     double depth_m, double speed_m_per_s) noexcept {
  const double put_J = state.objects[body].stiffness.follow(ownStiffness(scene, state, body), depth_m, speed_m_per_s,
                                                            config.maxForce_N, config.period_s);
  if (put_J == 0) return;
  state.energy.attribute(scene.objects[body].id, EnergyFeature::kEdit, put_J);
  state.limits.slew.begin();
}

void updateTouchedStiffness(const ServoScene& scene, HapticState& state, const StepConfig& config,
                            const ContactResult& contact, double speed_m_per_s) noexcept {
  const Vec3 penetration_m = contact.ihip - state.estimate.hip;
  if (state.adoption.fadingOut) return fadeHeld(state, config, penetration_m);
  const auto touched = static_cast<std::size_t>(contact.body);
  const double depth_m = severalBodiesHold(state) ? heldDepth_m(state, touched, penetration_m) : contact.penetration_m;
  updateStiffness(scene, state, config, touched, depth_m, speed_m_per_s);
}

void updateUntouchedStiffness(const ServoScene& scene, HapticState& state, const StepConfig& config,
                              const ContactResult& contact) noexcept {
  for (std::size_t i = 0; i < state.objects.count; ++i) {
    if (contact.touching && static_cast<std::size_t>(contact.body) == i) continue;
    if (state.objects[i].stiffness.value() == ownStiffness(scene, state, i)) continue;
    const double depth_m = severalBodiesHold(state) ? heldDepth_m(state, i, contact.ihip - state.estimate.hip) : 0;
    if (!state.adoption.fadingOut || !(depth_m > 0)) updateStiffness(scene, state, config, i, depth_m, 0);
  }
}

void followEdits(const ServoScene& scene, HapticState& state, const StepConfig& config) noexcept {
  if (state.features.beingMoved) moveObjects(scene, state, config);
  if (state.features.extras) releaseFaded(state);
}

void endEdits(HapticState& state) noexcept {
  for (std::size_t i = 0; i < state.objects.count; ++i) {
    const ObjectState& object = state.objects[i];
    if (!object.beingMoved) continue;
    state.objects[i].beingMoved = false;
    state.place(i, object.scenePose, object.scenePose);
  }
}

}  // namespace haptics

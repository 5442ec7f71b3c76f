#include "haptic_server/engine/step/haptic_step.h"

#include <algorithm>
#include <cmath>

#include "common/maths/rotation.h"
#include "haptic_server/engine/step/edited_objects.h"
#include "haptic_server/engine/step/effect_forces.h"
#include "haptic_server/engine/step/grasp.h"
#include "haptic_server/engine/step/held_springs.h"
#include "haptic_server/engine/step/kinematic_motion.h"
#include "haptic_server/engine/step/moving_bodies.h"
#include "haptic_server/engine/step/separation_speed.h"
#include "haptic_server/engine/step/soft_bodies.h"
#include "haptic_server/engine/step/surface_stages.h"
#include "haptic_server/engine/step/tool_step.h"
#include "haptic_server/engine/step/varying_springs.h"

namespace haptics {
namespace {

/// Older positions are not felt through: 5 ms at 0.2 m/s are a millimetre, several newtons on a stiff wall.
constexpr std::uint32_t kStalePosition_us = 5'000;

[[nodiscard, gnu::noinline]] bool turnsTool(const DevicePose& device) noexcept {
  return isRotation(device.rotation) && std::isfinite(device.gripper_rad);
}

[[nodiscard]] Fault faultOf(const DevicePose& device, bool holdsTool) noexcept {
  if (device.state != DeviceState::kReady) return Fault::kDeviceLost;
  if (device.status.fault != DeviceFault::kNone || !device.status.homed) return Fault::kDeviceLost;
  if (device.status.age_us > kStalePosition_us) return Fault::kDeviceStale;
  if (holdsTool && !turnsTool(device)) return Fault::kNonFiniteInput;
  return isWithinWorld(device.position) ? Fault::kNone : Fault::kNonFiniteInput;
}

/// While the hand moves its workspace the contact stays as it is, and the force goes and comes as by an edit, which lasts until
/// the clutch is let go.
void followClutch(HapticState& state, const StepInput& input) noexcept {
  const bool clutched = input.device.status.does(HandAction::kClutch);
  if (clutched == state.limits.clutched) return;
  state.limits.clutched = clutched;
  state.limits.slew.begin();
  state.now.clutchMoved = true;
}

/// The proxy is put where the device is: no force until a surface is met anew.
[[gnu::noinline, gnu::cold]] void attach(HapticState& state, const StepInput& input) noexcept {
  const Vec3 position = input.device.position;
  resetContact(state.contact, position);
  state.estimate.velocity.reset(position);
  if (state.observer.active()) state.observer.reset(position);
  state.estimate.measured = state.estimate.hip = position;
  if (state.features.tool) attachTool(state, input.device);
  state.energy.begin(position);
  state.report.object = 0;
  state.release();
  for (EffectMemory& effect : state.effects.all()) effect = {.object = effect.object, .number = effect.number};
  for (MovingBody& moving : state.moving.all()) moving.effectsRest_N = Vec3(0);
  if (state.features.detail) {
    state.surface.forget();
    std::ranges::fill(state.bumps.all(), BumpState{});
  }
  state.supervision.attached = true;
  state.limits.unlimited_N = Vec3(0);
}

/// Attaches at the first good reading, and again after a fault, but not before the force has been taken away.
[[gnu::always_inline]] inline void supervise(HapticState& state, const StepConfig& config,
                                             const StepInput& input) noexcept {
  const std::uint64_t missed = state.supervision.deadlines.missed(input.tick);
  Fault fault = faultOf(input.device, state.features.tool);
  if (missed > 0 && state.supervision.attached) [[unlikely]] {
    if (state.supervision.deadlines.tooMany(config.period_s)) {
      if (fault == Fault::kNone) fault = Fault::kDeadlinesMissed;
      if (state.supervision.fault == Fault::kNone) state.supervision.deadlines.giveUp(input.tick, config.period_s);
    } else if (state.observer.active()) {
      state.observer.skip(missed);
      if (state.features.tool || state.grasp.object != 0) state.tool.torque.skip(missed);
    } else {
      state.estimate.velocity.skip(missed);
    }
  }
  if (fault != Fault::kNone) {
    state.supervision.fault = fault;
  } else if (!state.supervision.attached ||
             (state.supervision.fault != Fault::kNone && state.supervision.ramp.atZero() &&
              state.supervision.deadlines.wait_s(input.tick, config.period_s) == 0)) {
    state.supervision.fault = Fault::kNone;
    attach(state, input);
    state.supervision.ramp.begin(config.rise_s);
  }
}

/// Along the normal of the touched surface, where it moves (m/s).
[[gnu::always_inline]] inline double surfaceSpeed(const HapticState& state, int body, Vec3 place, Vec3 normal,
                                                  const StepConfig& config) noexcept {
  if (body < 0 || !state.bodies[static_cast<std::size_t>(body)].moving) [[likely]]
    return 0;
  return glm::dot(state.estimate.velocity.velocity(), normal) -
         separationSpeed(state, body, place, normal, config.period_s);
}

/// Stiffness of the touched object, or of the tool that touches it; none when free.
[[gnu::always_inline]] inline Stiffness touchedStiffness(const HapticState& state,
                                                         const ContactResult& contact) noexcept {
  if (!contact.touching) return {};
  const std::size_t felt = state.features.tool ? state.tool.body : static_cast<std::size_t>(contact.body);
  return state.objects[felt].stiffness.value();
}

/// Of the touched surface with the effects that pull meanwhile, N/m; 0 when free.
[[gnu::noinline, gnu::cold]] double stiffnessWithExtras(const HapticState& state,
                                                        const ContactResult& contact) noexcept {
  if (!contact.touching) return 0;
  double all_N_per_m = touchedStiffness(state, contact).spring_N_per_m;
  for (std::size_t i = 0; i < state.effects.count; ++i) {
    if (state.effects[i].force_N != Vec3(0)) all_N_per_m += state.scene->effects[i].field->stiffness().spring_N_per_m;
  }
  return all_N_per_m;
}

void noteLimits(const ServoScene& scene, HapticState& state, const ContactWork& work) noexcept {
  if (work.allowanceSpent) ++state.report.allowanceSpent;
  if (work.depenetrated) {
    ++state.report.depenetrated;
    state.report.depenetratedFrom = scene.objects[static_cast<std::size_t>(work.insideOf)].id;
  }
  state.limits.slew.begin();  // the jump of the force is let in as an edit's is
}

/// How far the touched surface has gone by itself in this tick: not as an edit moves it.
[[nodiscard]] double carried_m(const HapticState& state, const ContactResult& contact) noexcept {
  if (!contact.touching) return 0;
  const auto touched = static_cast<std::size_t>(contact.body);
  const Body& body = state.bodies[touched];
  if (!body.moving || state.objects[touched].beingMoved) return 0;
  return glm::distance(toWorld(body.current, toLocal(body.previous, contact.ihip) + body.shift), contact.ihip);
}

/// The contact's force, with what a client adds.
[[nodiscard]] Vec3 allOf(const ForceResult& result) noexcept {
  return result.adds ? result.force.contact + result.added_N : result.force.contact;
}

/// Finite check, slew limit of an edit, fault ramp, magnitude limit: always last before the device.
[[gnu::noinline]] void limitByStages(HapticState& state, const StepConfig& config, const StepInput& input,
                                     ForceResult& result) noexcept {
  followClutch(state, input);
  if (result.adds && state.limits.clutched) result.added_N = Vec3(0);
  Vec3 force = allOf(result);
  if (!isFinite(force)) [[unlikely]]
    state.supervision.fault = Fault::kNonFiniteForce;
  if (state.supervision.fault == Fault::kNone) [[likely]] {
    if (state.limits.clutched) {
      force = Vec3(0);
      state.limits.slew.begin();
    }
    const bool edited = state.now.adopted && state.adoption.tick == input.tick;  // by more than a sample of a stream
    const bool jumps = state.now.contactBroken || state.now.clutchMoved || result.contact.work.depenetrated ||
                       result.contact.work.allowanceSpent || state.now.effectsEdited ||
                       (state.now.adopted && state.now.detailEdited) ||
                       (edited && result.object != state.report.object);
    if (jumps) state.limits.slew.begin();
    if (state.limits.slew.active()) {
      const Stiffness touched = touchedStiffness(state, result.contact);
      const EffectsFelt& effects = state.effectsFelt;
      const Vec3 before = limitMagnitude(state.limits.unlimited_N, config.maxForce_N);
      const double withinBefore =
          state.limits.slew.goesOn() ? effects.withinBefore : writtenFraction(before, state.limits.unlimited_N);
      const Vec3 felt = limitMagnitude(force, config.maxForce_N);
      state.limits.within = state.limits.clutched ? 0 : writtenFraction(felt, force);
      force = state.limits.slew.follow(
          before, felt, input.device.position, state.estimate.hip,
          std::max(carried_m(state, result.contact), effects.carried_m),
          {touched.spring_N_per_m + effects.stiffness.spring_N_per_m,
           touched.damping_Ns_per_m + effects.stiffness.damping_Ns_per_m},
          jumps, config.period_s, effects.byTime_N + (result.adds ? EditSlew::kRate_N_per_s * config.period_s : 0));
      if (state.features.effects) shareRest(state, withinBefore);
    }
    state.limits.unlimited_N = force;
    if (input.device.status.does(HandAction::kGrasp)) state.features.grasp = state.features.extras = true;
  } else {
    force = state.limits.unlimited_N;
    state.grasp.object = 0;
  }
  const bool isFaulty = state.supervision.fault != Fault::kNone;
  result.force.written =
      limitMagnitude(state.supervision.ramp.apply(isFaulty, force, config.period_s), config.maxForce_N);
  if (isFaulty && (state.features.tool || state.features.torqueFades)) limitTorque(state, result);
}

/// What is written of the contact's force. Fast path: no stage changes it.
[[gnu::always_inline]] inline void limit(HapticState& state, const StepConfig& config, const StepInput& input,
                                         ForceResult& result) noexcept {
  const Vec3& force = result.force.contact;
  const bool asItIs = state.supervision.fault == Fault::kNone && !state.now.adopted && !state.limits.slew.active() &&
                      state.supervision.ramp.atOne() && input.device.status.actions == 0;
  if (asItIs && glm::dot(force, force) <= config.maxForce_N * config.maxForce_N) [[likely]] {  // not for NaN
    result.force.written = state.limits.unlimited_N = force;
  } else {
    limitByStages(state, config, input, result);
  }
}

/// Where the HIP is, or will be while the coming force is held.
[[gnu::always_inline]] inline void estimateHip(HapticState& state, const Vec3& measured) noexcept {
  state.estimate.hip = measured;
  if (state.observer.active()) {
    state.estimate.hip = state.observer.follow(measured);
    state.estimate.velocity.set(state.estimate.hip, state.observer.velocity());
  } else {
    state.estimate.velocity.update(measured);
  }
}

/// What motions will take is kept, and after an adoption, which had its part, half of the rest.
[[nodiscard, gnu::always_inline]] inline Allowance contactAllowance(const HapticState& state,
                                                                    ForceResult& result) noexcept {
  Allowance allowance = state.allowance;
  if (state.moving.count > 0) [[unlikely]] {
    result.keptForMotion = unitsOfMotion(state);
    allowance.spend(result.keptForMotion);
  }
  if (state.now.adopted) [[unlikely]]
    allowance = Allowance(allowance.left() / 2);
  return allowance;
}

[[gnu::always_inline]] inline void findContact(const ServoScene& scene, HapticState& state, ForceResult& result,
                                               const TriangleCache* cache) noexcept {
  result.contact.work.allowance = contactAllowance(state, result);
  state.contactCache.ahead = cache;
  followContact(state.allBodies(), state.contact, state.estimate.hip, result.contact, state.contactCache);
  if (result.contact.work.depenetrated | result.contact.work.allowanceSpent) [[unlikely]]
    noteLimits(scene, state, result.contact.work);
}

/// Soft bodies yield, and springs that vary over the surface are as stiff as where they are touched.
void deform(const ServoScene& scene, HapticState& state, const StepConfig& config, ForceResult& result) noexcept {
  state.groove.shaded = false;
  if (state.features.varyingStiffness) varyStiffness(scene, state);
  if (state.features.soft) deformAtContact(scene, state, config, result);
}

/// On rigid and smooth bodies at rest: along the penetration vector. What SurfaceForceModel makes of them too, without
/// its list of what is felt.
[[gnu::always_inline]] inline void addSpringDamper(const ServoScene& scene, HapticState& state,
                                                   const StepConfig& config, ForceResult& result) noexcept {
  const ContactResult& contact = result.contact;
  if (!contact.touching) return;
  const auto touched = static_cast<std::size_t>(contact.body);
  const double depth = contact.penetration_m;
  const Vec3 direction =
      contact.alongNormal || depth <= 0 ? contact.normal : (contact.ihip - state.estimate.hip) / depth;
  const double speed = separationSpeed(state, contact.body, contact.ihip, direction, config.period_s);
  const RateLimitedStiffness& stiffness = state.objects[touched].stiffness;
  if (state.adoption.fadingOut || !(stiffness.value() == ownStiffness(scene, state, touched))) [[unlikely]]
    updateTouchedStiffness(scene, state, config, contact, speed);
  const SpringDamper along = springDamper(depth, speed, stiffness.value());
  result.force.spring = along.spring * direction;
  result.force.damping = along.damping * direction;
  if (state.contact.holdingCount > 1) [[unlikely]]
    result.force.spring += otherSprings_N(state, contact.ihip - state.estimate.hip);
  result.force.contact = result.force.spring + result.force.damping;
}

/// On what has surface properties, moves or is soft.
[[gnu::noinline]] void addSurfaceForces(const ServoScene& scene, HapticState& state, const StepConfig& config,
                                        ForceResult& result) noexcept {
  SurfaceForceModel surfaceForces(scene, state, config, result);
  surfaceForces.addShading();       // 4.1
  surfaceForces.addTexture();       // 4.3.1
  surfaceForces.addSpringDamper();  // 3, 4.3.2
  surfaceForces.addFriction();      // 4.2
  surfaceForces.writeResult();
}

/// At each press of its button: the scene is adopted once more, with that tool in the hand.
void takeNextTool(const ServoScene& scene, HapticState& state, const StepInput& input) noexcept {
  const bool pressed = input.device.status.does(HandAction::kNextTool);
  state.now.takesNextTool = pressed && !state.tool.nextPressed;
  state.tool.nextPressed = pressed;
  if (state.now.takesNextTool) (void)adoptScene(scene, state, input.tick);  // with a tool, nothing has to fade
}

/// With the tool in place of the point.
[[gnu::noinline]] void computeToolForce(const ServoScene& scene, HapticState& state, const StepConfig& config,
                                        const StepInput& input, ForceResult& result) noexcept {
  takeNextTool(scene, state, input);
  result.contact.work.allowance = contactAllowance(state, result);
  feelTool(scene, state, config, input.device, result);
  limitTorque(state, result);
  result.geometricNormal = result.contact.normal;
}

/// With the body that the hand holds in place of a contact.
[[gnu::noinline, gnu::cold]] void computeGraspForce(const ServoScene& scene, HapticState& state,
                                                    const StepConfig& config, const StepInput& input,
                                                    ForceResult& result) noexcept {
  result.contact.work.allowance = contactAllowance(state, result);
  feelGrasp(scene, state, config, input.device, result);
  limitTorque(state, result);
}

/// Contact and force where the HIP is.
[[gnu::always_inline]] inline void computeSurfaceForces(const ServoScene& scene, HapticState& state,
                                                        const StepConfig& config, ForceResult& result,
                                                        const TriangleCache* cache) noexcept {
  findContact(scene, state, result, cache);  // 3.2
  if (state.features.detail) [[unlikely]]
    deform(scene, state, config, result);  // 5 (d)
  if (state.observer.active()) result.geometricNormal = result.contact.normal;
  if (!state.features.detail) [[likely]] {
    addSpringDamper(scene, state, config, result);  // 3
  } else {
    addSurfaceForces(scene, state, config, result);  // 4
  }
}

[[gnu::always_inline]] inline void nameTouched(const ServoScene& scene, ForceResult& result) noexcept {
  if (result.contact.touching) result.object = scene.objects[static_cast<std::size_t>(result.contact.body)].id;
}

/// To the end, where objects are on their way or leave, a tool or a body is held, there are effects, or a client adds a force.
/// Apart, so that the compiler keeps nothing for it in a tick without.
[[gnu::noinline, gnu::cold]] void computeForceWithExtras(const ServoScene& scene, HapticState& state,
                                                         const StepConfig& config, const StepInput& input,
                                                         ForceResult& result, const TriangleCache* cache) noexcept {
  followClutch(state, input);
  followEdits(scene, state, config);
  if (state.features.tool) {
    computeToolForce(scene, state, config, input, result);
  } else if (state.features.grasp && followGrasp(state, input.device)) {
    computeGraspForce(scene, state, config, input, result);
  } else {
    if (state.features.torqueFades) fadeTorque(state, result);
    computeSurfaceForces(scene, state, config, result, cache);
  }
  if (state.features.effects) addEffectForces(scene, state, config, input, result);
  nameTouched(scene, result);
  result.adds ? limitByStages(state, config, input, result) : limit(state, config, input, result);
}

/// What an edit, the surface's features and a client have of the force that is now held.
[[gnu::noinline]] void holdParts(HapticState& state, const StepConfig& config, const ForceResult& result) noexcept {
  const double part = writtenFraction(result.force.written, state.limits.unlimited_N);
  if (state.limits.slew.active()) {
    const Vec3 whole_N = limitMagnitude(allOf(result), config.maxForce_N);
    state.energy.setHeldPart(EnergyFeature::kEdit, state.limits.unlimited_N - whole_N, part);
  }
  state.energy.setHeldPart(EnergyFeature::kShading, result.shadingForce_N, part);
  state.energy.setHeldPart(EnergyFeature::kFriction, result.force.friction, part);
  state.energy.setHeldPart(EnergyFeature::kTexture, result.force.texture, part);
  if (result.adds) state.energy.setHeldPart(EnergyFeature::kWrench, result.added_N, part);
}

/// What the last force gave the hand on the way to here, and what may give it some from now on.
[[gnu::always_inline]] inline void accountEnergy(HapticState& state, const StepConfig& config,
                                                 const ForceResult& result) noexcept {
  if (result.followed) [[likely]]
    state.energy.integrate(state.estimate.measured);
  state.energy.setHeldForce(result.object, result.force.written);
  if ((state.features.detail | result.adds) || state.limits.slew.active()) [[unlikely]]
    holdParts(state, config, result);
}

[[nodiscard, gnu::always_inline]] inline TelemetrySample telemetryOf(const HapticState& state, const StepInput& input,
                                                                     const ForceResult& result,
                                                                     double period_s) noexcept {
  const ContactResult& contact = result.contact;
  return {
      .tick = input.tick,
      .time_ns = input.time_ns,
      .sceneRevision = state.adoption.revision,
      .adoptionTick = state.adoption.tick,
      .deformationRevision = state.denting.revision,
      .hip = state.estimate.measured,
      .predictedHip = state.estimate.hip,
      .ihip = contact.touching ? contact.ihip : state.estimate.measured,
      .object = result.object,
      .primitive = {contact.primitive.kind, contact.primitive.localIndex, contact.primitive.polygon},
      .penetration_m = contact.penetration_m,
      .surfaceNormal = contact.normal,
      .frictionState = result.friction,
      .stickingPoint = result.stickingPoint,
      .height_m = result.height_m,
      .force = result.force,
      .energyGiven_J = state.energy.all_J(),
      .largestEnergySource = {},
      .fault = state.supervision.fault,
      .wait_s = state.supervision.fault == Fault::kNone ? 0 : state.supervision.deadlines.wait_s(input.tick, period_s),
      .deviceState = input.device.state,
      .device = input.device.status,
      .depenetrated = state.report.depenetrated,
      .depenetratedFrom = state.report.depenetratedFrom,
      .allowanceSpent = state.report.allowanceSpent,
      .grasped = state.grasp.object};
}

/// finishStep(), in hapticStep() too without a call.
[[gnu::always_inline]] inline TelemetrySample finish(const ServoScene& scene, HapticState& state,
                                                     const StepConfig& config, const StepInput& input,
                                                     const ForceResult& result) noexcept {
  const ContactResult& contact = result.contact;
  if (result.followed) [[likely]] {
    state.estimate.measured = input.device.position;
    if (!state.features.detail && (!contact.touching || state.objects.count > 1)) [[unlikely]]
      updateUntouchedStiffness(scene, state, config, contact);
  } else {
    if (state.features.beingMoved) endEdits(state);
    if (state.driven.count + state.reshaped.count > 0) moveDrivenObjects(scene, state, config.period_s);
  }
  if (state.moving.count > 0) [[unlikely]]
    moveBodies(state, config, result);  // 5 (c)
  state.report.object = result.object;
  accountEnergy(state, config, result);
  if (state.observer.active()) {
    const double stiffness_N_per_m =
        state.features.extras ? stiffnessWithExtras(state, contact) : touchedStiffness(state, contact).spring_N_per_m;
    state.observer.onForceWritten(result.force.written, result.geometricNormal, stiffness_N_per_m,
                                  surfaceSpeed(state, contact.body, contact.ihip, result.geometricNormal, config));
  }
  state.now = {};
  TelemetrySample sample = telemetryOf(state, input, result, config.period_s);
  if (result.adds) [[unlikely]]
    sample.added_N = result.added_N;
  return sample;
}

}  // namespace

// The paper's section stands beside each stage.
void computeForce(const ServoScene& scene, HapticState& state, const StepConfig& config, const StepInput& input,
                  ForceResult& result, const TriangleCache* cache) noexcept {
  supervise(state, config, input);
  if (state.moving.count > 0) [[unlikely]]
    takeMovedPoses(state);  // 5 (c)
  if (state.supervision.fault == Fault::kNone) [[likely]] {
    result.followed = true;
    estimateHip(state, input.device.position);
    if (state.features.beingMoved | state.features.extras | result.adds) [[unlikely]]
      return computeForceWithExtras(scene, state, config, input, result, cache);
    computeSurfaceForces(scene, state, config, result, cache);
    nameTouched(scene, result);
  }
  limit(state, config, input, result);
}

TelemetrySample finishStep(const ServoScene& scene, HapticState& state, const StepConfig& config,
                           const StepInput& input, const ForceResult& result) noexcept {
  return finish(scene, state, config, input, result);
}

TelemetrySample hapticStep(const ServoScene& scene, HapticState& state, const StepConfig& config,
                           const StepInput& input, const Vec3* added_N) noexcept {
  ForceResult result;
  if (added_N != nullptr) result.add(*added_N);
  computeForce(scene, state, config, input, result);
  return finish(scene, state, config, input, result);
}

}  // namespace haptics

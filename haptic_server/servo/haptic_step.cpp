#include "haptic_server/servo/haptic_step.h"

#include <algorithm>

#include "haptic_server/servo/feel_details.h"
#include "haptic_server/servo/felt_pose.h"
#include "haptic_server/servo/held_springs.h"
#include "haptic_server/servo/moving_bodies.h"
#include "haptic_server/servo/separation_speed.h"
#include "haptic_server/servo/soft_bodies.h"
#include "haptic_server/servo/varying_springs.h"

namespace haptics {
namespace {

/// Older positions are not felt through: 5 ms at 0.2 m/s are a millimetre, several newtons on a stiff wall.
constexpr std::uint32_t kStalePosition_us = 5'000;

[[nodiscard]] Fault faultOf(const DeviceReading& device) noexcept {
  if (device.state != DeviceState::kReady) return Fault::kDeviceLost;
  if (device.status.fault != DeviceFault::kNone || !device.status.homed) return Fault::kDeviceLost;
  if (device.status.age_us > kStalePosition_us) return Fault::kDeviceStale;
  return isPlace(device.position) ? Fault::kNone : Fault::kNonFiniteInput;
}

/// The proxy is put where the device is: no force until a surface is met anew.
void attach(HapticState& state, Vec3 position) noexcept {
  place(state.contact, position);
  state.velocity.reset(position);
  if (state.lead.active()) state.lead.reset(position);
  state.measuredHip = state.hip = position;
  state.energy.begin(position);
  state.contactObject = 0;
  state.release();
  if (state.anyDetail) {
    state.surface = {};
    std::fill_n(state.bumps.begin(), state.bodyCount, BumpWatch{});
  }
  state.attached = true;
  state.unlimited_N = Vec3(0);
}

/// Attaches at the first good reading, and again after a fault, but not before the force has been taken away.
[[gnu::always_inline]] inline void supervise(HapticState& state, const StepConfig& config,
                                             const StepInput& input) noexcept {
  const std::uint64_t missed = state.deadlines.missed(input.tick);
  Fault fault = faultOf(input.device);
  if (missed > 0 && state.attached) [[unlikely]] {
    if (state.deadlines.tooMany(config.period_s)) {
      if (fault == Fault::kNone) fault = Fault::kDeadlinesMissed;
      if (state.fault == Fault::kNone) state.deadlines.giveUp(input.tick, config.period_s);
    } else if (state.lead.active()) {
      state.lead.skip(missed);
    }
  }
  if (fault != Fault::kNone) {
    state.fault = fault;
  } else if (!state.attached || (state.fault != Fault::kNone && state.faultRamp.atZero() &&
                                 state.deadlines.wait_s(input.tick, config.period_s) == 0)) {
    state.fault = Fault::kNone;
    attach(state, input.device.position);
    state.faultRamp.begin(config.rise_s);
  }
}

/// Along the normal of the touched surface, where it moves (m/s).
[[gnu::always_inline]] inline double surfaceSpeed(const HapticState& state, int body, Vec3 place, Vec3 normal,
                                                  const StepConfig& config) noexcept {
  if (body < 0 || !state.bodies[static_cast<std::size_t>(body)].moving) [[likely]]
    return 0;
  return glm::dot(state.velocity.velocity(), normal) - separationSpeed(state, body, place, normal, config.period_s);
}

/// Of the touched object; none when free.
[[gnu::always_inline]] inline Stiffness feltStiffness(const HapticState& state, const ContactResult& contact) noexcept {
  if (!contact.touching) return {};
  return state.objects[static_cast<std::size_t>(contact.body)].felt.value();
}

[[nodiscard]] Stiffness ownStiffness(const ServoObject& object) noexcept {
  return object.leaving ? Stiffness{} : Stiffness{object.stiffness_N_per_m, object.damping_Ns_per_m};
}

/// Objects that were edited under the stylus, on their way to where the scene has them.
void moveEdited(const ServoScene& scene, HapticState& state, const StepConfig& config) noexcept {
  state.anyBeingMoved = false;
  state.slew.begin();
  for (std::size_t i = 0; i < state.bodyCount; ++i) {
    HapticState::ObjectState& object = state.objects[i];
    if (!object.beingMoved) continue;
    Body& body = state.bodies[i];
    object.beingMoved = !(body.current == object.scenePose);  // there: one more tick, at rest
    state.anyBeingMoved = state.anyBeingMoved || object.beingMoved;
    const Stiffness k = stiffer(object.felt.value(), ownStiffness(scene.objects[i]));
    const FeltPose felt(state.contact.hip, state.contact.ihip, k);
    body.previous = lastTestedPose(state, body);
    body.current = felt.next(body.current, object.scenePose, config.period_s);
    body.update();
    if (object.id != state.contactObject) continue;
    const Vec3 shift = toWorld(body.current, toLocal(body.previous, state.contact.ihip)) - state.contact.ihip;
    state.energy.name(object.id, EnergyFeature::kEdit, glm::dot(state.energy.written_N(), shift));
  }
}

/// The contact with an object that leaves the scene ends once that is not felt any more: what is behind it is felt then.
void letGoOfFaded(HapticState& state) noexcept {
  const auto hasFaded = [&](const HoldingSurface& held) {
    const auto body = static_cast<std::size_t>(held.body);
    return state.bodies[body].leaving && state.objects[body].felt.value() == Stiffness{};
  };
  if (!std::ranges::any_of(state.contact.surfaces(), hasFaded)) return;
  unseat(state.contact);
  state.contactBroken = true;
  state.slew.begin();
}

/// Of the touched object towards its own; with others that hold the IHIP it has a part of the penetration.
[[gnu::noinline]] void followStiffness(const ServoScene& scene, HapticState& state, const StepConfig& config,
                                       const ContactResult& contact, double speed_m_per_s) noexcept {
  const Vec3 penetration_m = contact.ihip - state.hip;
  if (state.lettingGo) return fadeHeld(state, config, penetration_m);
  const auto touched = static_cast<std::size_t>(contact.body);
  const double depth_m = severalBodiesHold(state) ? heldDepth_m(state, touched, penetration_m) : contact.penetration_m;
  const double put_J = state.objects[touched].felt.follow(ownStiffness(scene.objects[touched]), depth_m, speed_m_per_s,
                                                          config.maxForce_N, config.period_s);
  if (put_J == 0) return;
  state.energy.name(scene.objects[touched].id, EnergyFeature::kEdit, put_J);
  state.slew.begin();
}

[[gnu::noinline]] void addOtherSprings(const HapticState& state, const ContactResult& contact,
                                       ForceComponents& force) noexcept {
  force.spring += otherSprings_N(state, contact.ihip - state.hip);
}

/// Paper 3: spring from the penetration vector, with a damper. Moves the touched object's felt stiffness towards its own.
[[gnu::always_inline]] inline void feelSurface(const ServoScene& scene, HapticState& state, const StepConfig& config,
                                               const ContactResult& contact, ForceComponents& force) noexcept {
  if (!contact.touching) return;
  const auto touched = static_cast<std::size_t>(contact.body);
  const double depth = contact.penetration_m;
  const Vec3 direction = contact.alongNormal || depth <= 0 ? contact.normal : (contact.ihip - state.hip) / depth;
  const double speed = separationSpeed(state, contact.body, contact.ihip, direction, config.period_s);
  const FeltStiffness& felt = state.objects[touched].felt;
  if (state.lettingGo || !(felt.value() == ownStiffness(scene.objects[touched]))) [[unlikely]]
    followStiffness(scene, state, config, contact, speed);
  const SpringDamper along = springDamper(depth, speed, felt.value());
  force.spring = along.spring * direction;
  force.damping = along.damping * direction;
  if (state.contact.holdingCount > 1) [[unlikely]]
    addOtherSprings(state, contact, force);
}

/// Of a body that holds the IHIP with others, or none: then it is there at once.
[[gnu::noinline]] void followBeside(HapticState& state, const StepConfig& config, const ContactResult& contact,
                                    std::size_t body, Stiffness target) noexcept {
  const double depth_m = severalBodiesHold(state) ? heldDepth_m(state, body, contact.ihip - state.hip) : 0;
  if (state.lettingGo && depth_m > 0) return;
  const double put_J = state.objects[body].felt.follow(target, depth_m, 0, config.maxForce_N, config.period_s);
  if (put_J != 0) state.slew.begin();
}

[[gnu::always_inline]] inline void followUntouched(const ServoScene& scene, HapticState& state,
                                                   const StepConfig& config, const ContactResult& contact) noexcept {
  for (std::size_t i = 0; i < state.bodyCount; ++i) {
    if (contact.touching && static_cast<std::size_t>(contact.body) == i) continue;
    const Stiffness target = ownStiffness(scene.objects[i]);
    if (!(state.objects[i].felt.value() == target)) [[unlikely]]
      followBeside(state, config, contact, i, target);
  }
}

void noteLimits(const ServoScene& scene, HapticState& state, const ContactWork& work) noexcept {
  if (work.behind) ++state.behind;
  if (work.putOut) {
    ++state.putOut;
    state.putOutOf = scene.objects[static_cast<std::size_t>(work.insideOf)].id;
  }
  state.slew.begin();  // the jump of the force is let in as an edit's is
}

void followEdits(const ServoScene& scene, HapticState& state, const StepConfig& config) noexcept {
  if (state.anyBeingMoved) moveEdited(scene, state, config);
  if (state.anyLeaving) letGoOfFaded(state);
}

/// How far the touched surface has gone by itself in this tick: not as an edit moves it.
[[nodiscard]] double carried_m(const HapticState& state, const ContactResult& contact) noexcept {
  if (!contact.touching) return 0;
  const auto touched = static_cast<std::size_t>(contact.body);
  const Body& body = state.bodies[touched];
  if (!body.moving || state.objects[touched].beingMoved) return 0;
  return glm::distance(toWorld(body.current, toLocal(body.previous, contact.ihip)), contact.ihip);
}

/// Finite check, slew limit of an edit, fault ramp, magnitude limit: always last before the device.
[[nodiscard, gnu::noinline]] Vec3 limitedByStages(HapticState& state, const StepConfig& config, const FeltTick& felt,
                                                  const Vec3& measured, Vec3 force) noexcept {
  if (!isFinite(force)) [[unlikely]]
    state.fault = Fault::kNonFiniteForce;
  if (state.fault == Fault::kNone) [[likely]] {
    const bool jumps = state.contactBroken || felt.contact.work.putOut || felt.contact.work.behind ||
                       (state.adoptedNow && (state.detailEdited || felt.object != state.contactObject));
    if (jumps) state.slew.begin();
    if (state.slew.active()) {
      force = state.slew.follow(
          limitMagnitude(state.unlimited_N, config.maxForce_N), limitMagnitude(force, config.maxForce_N), measured,
          state.hip, carried_m(state, felt.contact), feltStiffness(state, felt.contact), jumps, config.period_s);
    }
    state.unlimited_N = force;
  } else {
    force = state.unlimited_N;
  }
  return limitMagnitude(state.faultRamp.apply(state.fault != Fault::kNone, force, config.period_s), config.maxForce_N);
}

/// A force that every stage passes on as it is, which most are, goes by none of them.
[[nodiscard, gnu::always_inline]] inline Vec3 limited(HapticState& state, const StepConfig& config,
                                                      const FeltTick& felt, const Vec3& measured,
                                                      const Vec3& force) noexcept {
  const bool asItIs =
      state.fault == Fault::kNone && !state.adoptedNow && !state.slew.active() && state.faultRamp.atOne();
  if (asItIs && glm::dot(force, force) <= config.maxForce_N * config.maxForce_N) [[likely]]  // not for NaN
    return state.unlimited_N = force;
  return limitedByStages(state, config, felt, measured, force);
}

/// Where the HIP is, or will be while the coming force is held.
[[gnu::always_inline]] inline void followHip(HapticState& state, const Vec3& measured) noexcept {
  state.hip = measured;
  if (state.lead.active()) {
    state.hip = state.lead.follow(measured);
    state.velocity.set(state.hip, state.lead.velocity());
  } else {
    state.velocity.update(measured);
  }
}

[[nodiscard, gnu::always_inline]] inline TelemetrySample describe(const HapticState& state, const StepInput& input,
                                                                  const FeltTick& felt, double period_s) noexcept {
  const ContactResult& contact = felt.contact;
  return {.tick = input.tick,
          .time_ns = input.time_ns,
          .sceneRevision = state.sceneRevision,
          .adoptionTick = state.adoptionTick,
          .hip = state.measuredHip,
          .foreseenHip = state.hip,
          .ihip = contact.touching ? contact.ihip : state.measuredHip,
          .object = felt.object,
          .primitive = {contact.primitive.kind, contact.primitive.localIndex, contact.primitive.polygon},
          .penetration_m = contact.penetration_m,
          .surfaceNormal = contact.normal,
          .force = felt.force,
          .energyGiven_J = state.energy.all_J(),
          .gaveMost = {},
          .fault = state.fault,
          .wait_s = state.fault == Fault::kNone ? 0 : state.deadlines.wait_s(input.tick, period_s),
          .deviceState = input.device.state,
          .device = input.device.status,
          .putOut = state.putOut,
          .putOutOf = state.putOutOf,
          .behind = state.behind};
}

/// What the last force gave the hand on the way to here, and what may give it some from now on.
template <bool kDetails>
[[gnu::always_inline]] inline void accountEnergy(HapticState& state, const StepConfig& config,
                                                 const FeltTick& felt) noexcept {
  if (felt.followed) [[likely]]
    state.energy.follow(state.measuredHip);
  state.energy.hold(felt.object, felt.force.written);
  const bool edited = state.slew.active();
  if (!kDetails && !edited) return;
  const double part = partWritten(felt.force.written, state.unlimited_N);
  if (edited) {
    const Vec3 whole_N = limitMagnitude(felt.force.contact, config.maxForce_N);
    state.energy.holdPart(EnergyFeature::kEdit, part * (state.unlimited_N - whole_N));
  }
  if constexpr (kDetails) {
    state.energy.holdPart(EnergyFeature::kShading, part * felt.shadingForce_N);
    state.energy.holdPart(EnergyFeature::kFriction, part * felt.force.friction);
    state.energy.holdPart(EnergyFeature::kTexture, part * felt.force.texture);
    if (felt.followed) state.surface.frictionForce_N = felt.force.friction;
  }
}

void describeDetails(const HapticState& state, const FeltTick& felt, TelemetrySample& sample) noexcept {
  sample.deformationRevision = state.deformationRevision;
  sample.frictionState = felt.friction;
  sample.stickingPoint = felt.stickingPoint;
  sample.height_m = felt.height_m;
}

// Both halves of the step are there for scenes in which some object has surface properties, moves or is soft, and for
// those without, where all of that costs nothing: for that their stages are inlined into both.

template <bool kDetails>
[[gnu::always_inline]] inline void feel(const ServoScene& scene, HapticState& state, const StepConfig& config,
                                        const StepInput& input, FeltTick& felt, const KnownPolygons* known) noexcept {
  supervise(state, config, input);
  if constexpr (kDetails) {
    if (state.movingCount > 0) [[unlikely]]
      takeMovedPoses(state);
  }
  if (state.fault == Fault::kNone) [[likely]] {
    felt.followed = true;
    followHip(state, input.device.position);
    if (state.anyBeingMoved | state.anyLeaving) [[unlikely]]
      followEdits(scene, state, config);
    felt.contact.work.allowance = state.allowance;
    if constexpr (kDetails) {
      if (state.movingCount > 0) [[unlikely]]
        felt.contact.work.allowance = besideMotion(state);
    }
    if (state.adoptedNow) [[unlikely]]
      felt.contact.work.allowance = Allowance(felt.contact.work.allowance.left() / 2);  // the adoption had its part
    followContact({state.bodies.data(), state.bodyCount}, state.contact, state.hip, felt.contact, known);
    if (felt.contact.work.putOut | felt.contact.work.behind) [[unlikely]]
      noteLimits(scene, state, felt.contact.work);
    if constexpr (kDetails) {
      state.groove.shaded = false;
      if (state.anyVaryingStiffness) [[unlikely]]
        varyStiffness(scene, state);
      if (state.anySoft) [[unlikely]]
        yieldToContact(scene, state, config, felt);
    }
    if (state.lead.active()) felt.geometricNormal = felt.contact.normal;
    if constexpr (kDetails) {
      feelDetails(scene, state, config, felt);
    } else {
      feelSurface(scene, state, config, felt.contact, felt.force);
    }
  }
  if (felt.contact.touching) felt.object = scene.objects[static_cast<std::size_t>(felt.contact.body)].id;
  ForceComponents& force = felt.force;
  force.contact = force.spring + force.damping;
  if constexpr (kDetails) force.contact += force.friction + force.texture;
  force.written = limited(state, config, felt, input.device.position, force.contact);
}

template <bool kDetails>
[[nodiscard, gnu::always_inline]] inline TelemetrySample finish(const ServoScene& scene, HapticState& state,
                                                                const StepConfig& config, const StepInput& input,
                                                                const FeltTick& felt) noexcept {
  if (felt.followed) [[likely]] {
    state.measuredHip = input.device.position;
    if constexpr (!kDetails) {
      const bool anyUntouched = !felt.contact.touching || state.bodyCount > 1;
      if (anyUntouched) [[unlikely]]
        followUntouched(scene, state, config, felt.contact);
    }
  }
  if constexpr (kDetails) {
    if (state.movingCount > 0) [[unlikely]]
      moveBodies(state, config, felt.contact, felt.force);
  }
  state.contactObject = felt.object;
  accountEnergy<kDetails>(state, config, felt);
  if (state.lead.active()) {
    const ContactResult& contact = felt.contact;
    state.lead.note(felt.force.written, felt.geometricNormal, feltStiffness(state, contact).spring_N_per_m,
                    surfaceSpeed(state, contact.body, contact.ihip, felt.geometricNormal, config));
  }
  state.adoptedNow = state.contactBroken = state.detailEdited = false;
  TelemetrySample sample = describe(state, input, felt, config.period_s);
  if constexpr (kDetails) describeDetails(state, felt, sample);
  return sample;
}

[[gnu::noinline]] void feelWithDetails(const ServoScene& scene, HapticState& state, const StepConfig& config,
                                       const StepInput& input, FeltTick& felt, const KnownPolygons* known) noexcept {
  feel<true>(scene, state, config, input, felt, known);
}

[[nodiscard, gnu::noinline]] TelemetrySample finishWithDetails(const ServoScene& scene, HapticState& state,
                                                               const StepConfig& config, const StepInput& input,
                                                               const FeltTick& felt) noexcept {
  return finish<true>(scene, state, config, input, felt);
}

}  // namespace

void feelForce(const ServoScene& scene, HapticState& state, const StepConfig& config, const StepInput& input,
               FeltTick& felt, const KnownPolygons* known) noexcept {
  if (state.anyDetail) [[unlikely]]
    return feelWithDetails(scene, state, config, input, felt, known);
  feel<false>(scene, state, config, input, felt, known);
}

TelemetrySample finishStep(const ServoScene& scene, HapticState& state, const StepConfig& config,
                           const StepInput& input, const FeltTick& felt) noexcept {
  if (state.anyDetail) [[unlikely]]
    return finishWithDetails(scene, state, config, input, felt);
  return finish<false>(scene, state, config, input, felt);
}

TelemetrySample hapticStep(const ServoScene& scene, HapticState& state, const StepConfig& config,
                           const StepInput& input) noexcept {
  FeltTick felt;
  feelForce(scene, state, config, input, felt);
  return finishStep(scene, state, config, input, felt);
}

}  // namespace haptics

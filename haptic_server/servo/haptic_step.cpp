#include "haptic_server/servo/haptic_step.h"

#include <algorithm>

#include "haptic_server/servo/edited_objects.h"
#include "haptic_server/servo/feel_details.h"
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

void noteLimits(const ServoScene& scene, HapticState& state, const ContactWork& work) noexcept {
  if (work.behind) ++state.behind;
  if (work.putOut) {
    ++state.putOut;
    state.putOutOf = scene.objects[static_cast<std::size_t>(work.insideOf)].id;
  }
  state.slew.begin();  // the jump of the force is let in as an edit's is
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
[[gnu::always_inline]] inline void estimateHip(HapticState& state, const Vec3& measured) noexcept {
  state.hip = measured;
  if (state.lead.active()) {
    state.hip = state.lead.follow(measured);
    state.velocity.set(state.hip, state.lead.velocity());
  } else {
    state.velocity.update(measured);
  }
}

/// What motions will take is kept, and after an adoption, which had its part, half of the rest.
[[nodiscard, gnu::always_inline]] inline Allowance contactAllowance(const HapticState& state, FeltTick& felt) noexcept {
  Allowance allowance = state.allowance;
  if (state.movingCount > 0) [[unlikely]] {
    felt.keptForMotion = unitsOfMotion(state);
    allowance.spend(felt.keptForMotion);
  }
  if (state.adoptedNow) [[unlikely]]
    allowance = Allowance(allowance.left() / 2);
  return allowance;
}

[[gnu::always_inline]] inline void findContact(const ServoScene& scene, HapticState& state, FeltTick& felt,
                                               const KnownPolygons* known) noexcept {
  felt.contact.work.allowance = contactAllowance(state, felt);
  followContact({state.bodies.data(), state.bodyCount}, state.contact, state.hip, felt.contact, known);
  if (felt.contact.work.putOut | felt.contact.work.behind) [[unlikely]]
    noteLimits(scene, state, felt.contact.work);
}

/// Soft bodies yield, and springs that vary over the surface are as stiff as where they are touched.
void deform(const ServoScene& scene, HapticState& state, const StepConfig& config, FeltTick& felt) noexcept {
  state.groove.shaded = false;
  if (state.anyVaryingStiffness) varyStiffness(scene, state);
  if (state.anySoft) yieldToContact(scene, state, config, felt);
}

/// On rigid and smooth bodies at rest: along the penetration vector. What Feeling makes of them too, without its list of
/// what is felt.
[[gnu::always_inline]] inline void addSpringDamper(const ServoScene& scene, HapticState& state,
                                                   const StepConfig& config, FeltTick& felt) noexcept {
  const ContactResult& contact = felt.contact;
  if (!contact.touching) return;
  const auto touched = static_cast<std::size_t>(contact.body);
  const double depth = contact.penetration_m;
  const Vec3 direction = contact.alongNormal || depth <= 0 ? contact.normal : (contact.ihip - state.hip) / depth;
  const double speed = separationSpeed(state, contact.body, contact.ihip, direction, config.period_s);
  const FeltStiffness& stiffness = state.objects[touched].felt;
  if (state.lettingGo || !(stiffness.value() == ownStiffness(scene, state, touched))) [[unlikely]]
    followTouched(scene, state, config, contact, speed);
  const SpringDamper along = springDamper(depth, speed, stiffness.value());
  felt.force.spring = along.spring * direction;
  felt.force.damping = along.damping * direction;
  if (state.contact.holdingCount > 1) [[unlikely]]
    felt.force.spring += otherSprings_N(state, contact.ihip - state.hip);
  felt.force.contact = felt.force.spring + felt.force.damping;
}

/// On what has surface properties, moves or is soft.
[[gnu::noinline]] void addSurfaceForces(const ServoScene& scene, HapticState& state, const StepConfig& config,
                                        FeltTick& felt) noexcept {
  Feeling feeling(scene, state, config, felt);
  feeling.addShading();       // 4.1
  feeling.addTexture();       // 4.3.1
  feeling.addSpringDamper();  // 3, 4.3.2
  feeling.addFriction();      // 4.2
  feeling.describe();
}

/// What an edit and the surface's features have of the force that is now held.
[[gnu::noinline]] void holdParts(HapticState& state, const StepConfig& config, const FeltTick& felt) noexcept {
  const double part = partWritten(felt.force.written, state.unlimited_N);
  if (state.slew.active()) {
    const Vec3 whole_N = limitMagnitude(felt.force.contact, config.maxForce_N);
    state.energy.holdPart(EnergyFeature::kEdit, part * (state.unlimited_N - whole_N));
  }
  state.energy.holdPart(EnergyFeature::kShading, part * felt.shadingForce_N);
  state.energy.holdPart(EnergyFeature::kFriction, part * felt.force.friction);
  state.energy.holdPart(EnergyFeature::kTexture, part * felt.force.texture);
}

/// What the last force gave the hand on the way to here, and what may give it some from now on.
[[gnu::always_inline]] inline void accountEnergy(HapticState& state, const StepConfig& config,
                                                 const FeltTick& felt) noexcept {
  if (felt.followed) [[likely]]
    state.energy.follow(state.measuredHip);
  state.energy.hold(felt.object, felt.force.written);
  if (state.anyDetail || state.slew.active()) [[unlikely]]
    holdParts(state, config, felt);
}

[[nodiscard, gnu::always_inline]] inline TelemetrySample describe(const HapticState& state, const StepInput& input,
                                                                  const FeltTick& felt, double period_s) noexcept {
  const ContactResult& contact = felt.contact;
  return {.tick = input.tick,
          .time_ns = input.time_ns,
          .sceneRevision = state.sceneRevision,
          .adoptionTick = state.adoptionTick,
          .deformationRevision = state.deformationRevision,
          .hip = state.measuredHip,
          .foreseenHip = state.hip,
          .ihip = contact.touching ? contact.ihip : state.measuredHip,
          .object = felt.object,
          .primitive = {contact.primitive.kind, contact.primitive.localIndex, contact.primitive.polygon},
          .penetration_m = contact.penetration_m,
          .surfaceNormal = contact.normal,
          .frictionState = felt.friction,
          .stickingPoint = felt.stickingPoint,
          .height_m = felt.height_m,
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

}  // namespace

// The paper's section stands beside each stage.
void feelForce(const ServoScene& scene, HapticState& state, const StepConfig& config, const StepInput& input,
               FeltTick& felt, const KnownPolygons* known) noexcept {
  supervise(state, config, input);
  if (state.movingCount > 0) [[unlikely]]
    takeMovedPoses(state);  // 5 (c)
  if (state.fault == Fault::kNone) [[likely]] {
    felt.followed = true;
    estimateHip(state, input.device.position);
    if (state.anyBeingMoved | state.anyLeaving) [[unlikely]]
      followEdits(scene, state, config);
    findContact(scene, state, felt, known);  // 3.2
    if (state.anyDetail) [[unlikely]]
      deform(scene, state, config, felt);  // 5 (d)
    if (state.lead.active()) felt.geometricNormal = felt.contact.normal;
    if (!state.anyDetail) [[likely]] {
      addSpringDamper(scene, state, config, felt);  // 3
    } else {
      addSurfaceForces(scene, state, config, felt);  // 4
    }
  }
  if (felt.contact.touching) felt.object = scene.objects[static_cast<std::size_t>(felt.contact.body)].id;
  felt.force.written = limited(state, config, felt, input.device.position, felt.force.contact);
}

TelemetrySample finishStep(const ServoScene& scene, HapticState& state, const StepConfig& config,
                           const StepInput& input, const FeltTick& felt) noexcept {
  const ContactResult& contact = felt.contact;
  if (felt.followed) [[likely]] {
    state.measuredHip = input.device.position;
    if (!state.anyDetail && (!contact.touching || state.bodyCount > 1)) [[unlikely]]
      followUntouched(scene, state, config, contact);
  }
  if (state.movingCount > 0) [[unlikely]]
    moveBodies(state, config, felt);  // 5 (c)
  state.contactObject = felt.object;
  accountEnergy(state, config, felt);
  if (state.lead.active()) {
    state.lead.note(felt.force.written, felt.geometricNormal, feltStiffness(state, contact).spring_N_per_m,
                    surfaceSpeed(state, contact.body, contact.ihip, felt.geometricNormal, config));
  }
  state.adoptedNow = state.contactBroken = state.detailEdited = false;
  return describe(state, input, felt, config.period_s);
}

TelemetrySample hapticStep(const ServoScene& scene, HapticState& state, const StepConfig& config,
                           const StepInput& input) noexcept {
  FeltTick felt;
  feelForce(scene, state, config, input, felt);
  return finishStep(scene, state, config, input, felt);
}

}  // namespace haptics

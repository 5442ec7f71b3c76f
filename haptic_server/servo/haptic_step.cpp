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
  state.estimate.velocity.reset(position);
  if (state.lead.active()) state.lead.reset(position);
  state.estimate.measured = state.estimate.hip = position;
  state.energy.begin(position);
  state.report.object = 0;
  state.release();
  if (state.features.detail) {
    state.surface = {};
    std::fill_n(state.bumps.begin(), state.adoption.bodyCount, BumpWatch{});
  }
  state.supervision.attached = true;
  state.limits.unlimited_N = Vec3(0);
}

/// Attaches at the first good reading, and again after a fault, but not before the force has been taken away.
[[gnu::always_inline]] inline void supervise(HapticState& state, const StepConfig& config,
                                             const StepInput& input) noexcept {
  const std::uint64_t missed = state.supervision.deadlines.missed(input.tick);
  Fault fault = faultOf(input.device);
  if (missed > 0 && state.supervision.attached) [[unlikely]] {
    if (state.supervision.deadlines.tooMany(config.period_s)) {
      if (fault == Fault::kNone) fault = Fault::kDeadlinesMissed;
      if (state.supervision.fault == Fault::kNone) state.supervision.deadlines.giveUp(input.tick, config.period_s);
    } else if (state.lead.active()) {
      state.lead.skip(missed);
    }
  }
  if (fault != Fault::kNone) {
    state.supervision.fault = fault;
  } else if (!state.supervision.attached ||
             (state.supervision.fault != Fault::kNone && state.supervision.ramp.atZero() &&
              state.supervision.deadlines.wait_s(input.tick, config.period_s) == 0)) {
    state.supervision.fault = Fault::kNone;
    attach(state, input.device.position);
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

/// Of the touched object; none when free.
[[gnu::always_inline]] inline Stiffness feltStiffness(const HapticState& state, const ContactResult& contact) noexcept {
  if (!contact.touching) return {};
  return state.objects[static_cast<std::size_t>(contact.body)].felt.value();
}

void noteLimits(const ServoScene& scene, HapticState& state, const ContactWork& work) noexcept {
  if (work.behind) ++state.report.behind;
  if (work.putOut) {
    ++state.report.putOut;
    state.report.putOutOf = scene.objects[static_cast<std::size_t>(work.insideOf)].id;
  }
  state.limits.slew.begin();  // the jump of the force is let in as an edit's is
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
    state.supervision.fault = Fault::kNonFiniteForce;
  if (state.supervision.fault == Fault::kNone) [[likely]] {
    const bool jumps = state.adoption.contactBroken || felt.contact.work.putOut || felt.contact.work.behind ||
                       (state.adoption.now && (state.adoption.detailEdited || felt.object != state.report.object));
    if (jumps) state.limits.slew.begin();
    if (state.limits.slew.active()) {
      force = state.limits.slew.follow(limitMagnitude(state.limits.unlimited_N, config.maxForce_N),
                                       limitMagnitude(force, config.maxForce_N), measured, state.estimate.hip,
                                       carried_m(state, felt.contact), feltStiffness(state, felt.contact), jumps,
                                       config.period_s);
    }
    state.limits.unlimited_N = force;
  } else {
    force = state.limits.unlimited_N;
  }
  return limitMagnitude(state.supervision.ramp.apply(state.supervision.fault != Fault::kNone, force, config.period_s),
                        config.maxForce_N);
}

/// A force that every stage passes on as it is, which most are, goes by none of them.
[[nodiscard, gnu::always_inline]] inline Vec3 limited(HapticState& state, const StepConfig& config,
                                                      const FeltTick& felt, const Vec3& measured,
                                                      const Vec3& force) noexcept {
  const bool asItIs = state.supervision.fault == Fault::kNone && !state.adoption.now && !state.limits.slew.active() &&
                      state.supervision.ramp.atOne();
  if (asItIs && glm::dot(force, force) <= config.maxForce_N * config.maxForce_N) [[likely]]  // not for NaN
    return state.limits.unlimited_N = force;
  return limitedByStages(state, config, felt, measured, force);
}

/// Where the HIP is, or will be while the coming force is held.
[[gnu::always_inline]] inline void estimateHip(HapticState& state, const Vec3& measured) noexcept {
  state.estimate.hip = measured;
  if (state.lead.active()) {
    state.estimate.hip = state.lead.follow(measured);
    state.estimate.velocity.set(state.estimate.hip, state.lead.velocity());
  } else {
    state.estimate.velocity.update(measured);
  }
}

/// What motions will take is kept, and after an adoption, which had its part, half of the rest.
[[nodiscard, gnu::always_inline]] inline Allowance contactAllowance(const HapticState& state, FeltTick& felt) noexcept {
  Allowance allowance = state.allowance;
  if (state.motion.count > 0) [[unlikely]] {
    felt.keptForMotion = unitsOfMotion(state);
    allowance.spend(felt.keptForMotion);
  }
  if (state.adoption.now) [[unlikely]]
    allowance = Allowance(allowance.left() / 2);
  return allowance;
}

[[gnu::always_inline]] inline void findContact(const ServoScene& scene, HapticState& state, FeltTick& felt,
                                               const KnownPolygons* known) noexcept {
  felt.contact.work.allowance = contactAllowance(state, felt);
  followContact({state.bodies.data(), state.adoption.bodyCount}, state.contact, state.estimate.hip, felt.contact,
                known);
  if (felt.contact.work.putOut | felt.contact.work.behind) [[unlikely]]
    noteLimits(scene, state, felt.contact.work);
}

/// Soft bodies yield, and springs that vary over the surface are as stiff as where they are touched.
void deform(const ServoScene& scene, HapticState& state, const StepConfig& config, FeltTick& felt) noexcept {
  state.groove.shaded = false;
  if (state.features.varyingStiffness) varyStiffness(scene, state);
  if (state.features.soft) yieldToContact(scene, state, config, felt);
}

/// On rigid and smooth bodies at rest: along the penetration vector. What Feeling makes of them too, without its list of
/// what is felt.
[[gnu::always_inline]] inline void addSpringDamper(const ServoScene& scene, HapticState& state,
                                                   const StepConfig& config, FeltTick& felt) noexcept {
  const ContactResult& contact = felt.contact;
  if (!contact.touching) return;
  const auto touched = static_cast<std::size_t>(contact.body);
  const double depth = contact.penetration_m;
  const Vec3 direction =
      contact.alongNormal || depth <= 0 ? contact.normal : (contact.ihip - state.estimate.hip) / depth;
  const double speed = separationSpeed(state, contact.body, contact.ihip, direction, config.period_s);
  const FeltStiffness& stiffness = state.objects[touched].felt;
  if (state.adoption.lettingGo || !(stiffness.value() == ownStiffness(scene, state, touched))) [[unlikely]]
    followTouched(scene, state, config, contact, speed);
  const SpringDamper along = springDamper(depth, speed, stiffness.value());
  felt.force.spring = along.spring * direction;
  felt.force.damping = along.damping * direction;
  if (state.contact.holdingCount > 1) [[unlikely]]
    felt.force.spring += otherSprings_N(state, contact.ihip - state.estimate.hip);
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
  const double part = partWritten(felt.force.written, state.limits.unlimited_N);
  if (state.limits.slew.active()) {
    const Vec3 whole_N = limitMagnitude(felt.force.contact, config.maxForce_N);
    state.energy.holdPart(EnergyFeature::kEdit, part * (state.limits.unlimited_N - whole_N));
  }
  state.energy.holdPart(EnergyFeature::kShading, part * felt.shadingForce_N);
  state.energy.holdPart(EnergyFeature::kFriction, part * felt.force.friction);
  state.energy.holdPart(EnergyFeature::kTexture, part * felt.force.texture);
}

/// What the last force gave the hand on the way to here, and what may give it some from now on.
[[gnu::always_inline]] inline void accountEnergy(HapticState& state, const StepConfig& config,
                                                 const FeltTick& felt) noexcept {
  if (felt.followed) [[likely]]
    state.energy.follow(state.estimate.measured);
  state.energy.hold(felt.object, felt.force.written);
  if (state.features.detail || state.limits.slew.active()) [[unlikely]]
    holdParts(state, config, felt);
}

[[nodiscard, gnu::always_inline]] inline TelemetrySample describe(const HapticState& state, const StepInput& input,
                                                                  const FeltTick& felt, double period_s) noexcept {
  const ContactResult& contact = felt.contact;
  return {
      .tick = input.tick,
      .time_ns = input.time_ns,
      .sceneRevision = state.adoption.revision,
      .adoptionTick = state.adoption.tick,
      .deformationRevision = state.denting.revision,
      .hip = state.estimate.measured,
      .foreseenHip = state.estimate.hip,
      .ihip = contact.touching ? contact.ihip : state.estimate.measured,
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
      .fault = state.supervision.fault,
      .wait_s = state.supervision.fault == Fault::kNone ? 0 : state.supervision.deadlines.wait_s(input.tick, period_s),
      .deviceState = input.device.state,
      .device = input.device.status,
      .putOut = state.report.putOut,
      .putOutOf = state.report.putOutOf,
      .behind = state.report.behind};
}

}  // namespace

// The paper's section stands beside each stage.
void feelForce(const ServoScene& scene, HapticState& state, const StepConfig& config, const StepInput& input,
               FeltTick& felt, const KnownPolygons* known) noexcept {
  supervise(state, config, input);
  if (state.motion.count > 0) [[unlikely]]
    takeMovedPoses(state);  // 5 (c)
  if (state.supervision.fault == Fault::kNone) [[likely]] {
    felt.followed = true;
    estimateHip(state, input.device.position);
    if (state.features.beingMoved | state.features.leaving) [[unlikely]]
      followEdits(scene, state, config);
    findContact(scene, state, felt, known);  // 3.2
    if (state.features.detail) [[unlikely]]
      deform(scene, state, config, felt);  // 5 (d)
    if (state.lead.active()) felt.geometricNormal = felt.contact.normal;
    if (!state.features.detail) [[likely]] {
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
    state.estimate.measured = input.device.position;
    if (!state.features.detail && (!contact.touching || state.adoption.bodyCount > 1)) [[unlikely]]
      followUntouched(scene, state, config, contact);
  }
  if (state.motion.count > 0) [[unlikely]]
    moveBodies(state, config, felt);  // 5 (c)
  state.report.object = felt.object;
  accountEnergy(state, config, felt);
  if (state.lead.active()) {
    state.lead.note(felt.force.written, felt.geometricNormal, feltStiffness(state, contact).spring_N_per_m,
                    surfaceSpeed(state, contact.body, contact.ihip, felt.geometricNormal, config));
  }
  state.adoption.now = state.adoption.contactBroken = state.adoption.detailEdited = false;
  return describe(state, input, felt, config.period_s);
}

TelemetrySample hapticStep(const ServoScene& scene, HapticState& state, const StepConfig& config,
                           const StepInput& input) noexcept {
  FeltTick felt;
  feelForce(scene, state, config, input, felt);
  return finishStep(scene, state, config, input, felt);
}

}  // namespace haptics

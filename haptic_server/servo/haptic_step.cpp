#include "haptic_server/servo/haptic_step.h"

#include <algorithm>

#include "haptic_server/servo/feel_details.h"
#include "haptic_server/servo/felt_pose.h"
#include "haptic_server/servo/moving_bodies.h"
#include "haptic_server/servo/separation_speed.h"
#include "haptic_server/servo/soft_bodies.h"

namespace haptics {
namespace {

/// Older positions are not felt through: 5 ms at 0.2 m/s are a millimetre, several newtons on a stiff wall.
constexpr std::uint32_t kStalePosition_us = 5'000;

[[nodiscard]] Fault faultOf(const DeviceReading& device) noexcept {
  if (device.state != DeviceState::kReady) return Fault::kDeviceLost;
  if (device.status.fault != DeviceFault::kNone || !device.status.homed) return Fault::kDeviceLost;
  if (device.status.age_us > kStalePosition_us) return Fault::kDeviceStale;
  return isFinite(device.position) ? Fault::kNone : Fault::kNonFiniteInput;
}

/// The proxy is put where the device is: no force until a surface is met anew.
void attach(HapticState& state, Vec3 position) noexcept {
  place(state.contact, position);
  state.velocity.reset(position);
  if (state.lead.active()) state.lead.reset(position);
  state.measuredHip = state.hip = position;
  state.contactObject = 0;
  state.release();
  if (state.anyDetail) {
    state.surface.forget();
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
    } else if (state.lead.active()) {
      state.lead.skip(missed);
    }
  }
  if (fault != Fault::kNone) {
    state.fault = fault;
  } else if (!state.attached || (state.fault != Fault::kNone && state.faultRamp.atZero())) {
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

/// Objects that were edited under the stylus, on their way to where the scene has them.
void moveEdited(HapticState& state, const StepConfig& config) noexcept {
  if (!state.anyBeingMoved) return;
  state.anyBeingMoved = false;
  for (std::size_t i = 0; i < state.bodyCount; ++i) {
    HapticState::ObjectState& object = state.objects[i];
    if (!object.beingMoved) continue;
    Body& body = state.bodies[i];
    object.beingMoved = !(body.current == object.scenePose);  // there: one more tick, at rest
    state.anyBeingMoved = state.anyBeingMoved || object.beingMoved;
    const FeltPose felt(state.contact.hip, state.contact.ihip, object.felt.value());
    body.previous = body.current;
    body.current = felt.next(body.current, object.scenePose, config.period_s);
    body.update();
  }
}

/// Paper 3: spring from the penetration vector, with a damper. Also moves every object's felt stiffness towards its
/// own.
void feelSurfaces(const ServoScene& scene, HapticState& state, const StepConfig& config, const ContactResult& contact,
                  ForceComponents& force) noexcept {
  const double depth = contact.penetration_m;
  const Vec3 direction = depth > 0 ? (contact.ihip - state.hip) / depth : contact.normal;
  const double speed =
      contact.touching ? separationSpeed(state, contact.body, contact.ihip, direction, config.period_s) : 0;
  for (std::size_t i = 0; i < state.bodyCount; ++i) {
    const ServoObject& object = scene.objects[i];
    const bool touched = contact.touching && static_cast<std::size_t>(contact.body) == i;
    const bool fading = object.leaving || (touched && state.lettingGo);
    const Stiffness target = fading ? Stiffness{} : Stiffness{object.stiffness_N_per_m, object.damping_Ns_per_m};
    state.objects[i].felt.follow(target, touched ? depth : 0, touched ? speed : 0, config.period_s);
  }
  if (state.lettingGo) state.letGo_s += config.period_s;
  if (!contact.touching) return;
  const auto felt =
      springDamper(depth, direction, speed, state.objects[static_cast<std::size_t>(contact.body)].felt.value());
  force.spring = felt.spring;
  force.damping = felt.damping;
}

/// Finite check, blend, fault ramp, magnitude limit: always last before the device.
[[gnu::always_inline]] inline void limitForce(HapticState& state, const StepConfig& config, std::uint64_t touchedObject,
                                              ForceComponents& force) noexcept {
  if (!isFinite(force.contact)) state.fault = Fault::kNonFiniteForce;
  if (state.fault == Fault::kNone) {
    if (state.adoptedNow && (state.contactBroken || state.detailEdited || touchedObject != state.contactObject)) {
      state.blend.begin(state.unlimited_N, force.contact);
    }
    state.unlimited_N = state.blend.apply(force.contact, config.period_s);
  }
  const Vec3 ramped = state.faultRamp.apply(state.fault != Fault::kNone, state.unlimited_N, config.period_s);
  force.written = limitMagnitude(ramped, config.maxForce_N);
}

/// Where the HIP is, or will be while the coming force is held; and what the last force gave the hand on the way.
[[gnu::always_inline]] inline void followHip(HapticState& state, Vec3 measured) noexcept {
  state.contactEnergy_J += glm::dot(state.written_N, measured - state.measuredHip);
  state.measuredHip = measured;
  state.hip = measured;
  if (state.lead.active()) {
    state.hip = state.lead.follow(measured);
    state.velocity.set(state.hip, state.lead.velocity());
  } else {
    state.velocity.update(measured);
  }
}

void describe(const HapticState& state, const ContactResult& contact, const ForceComponents& force,
              TelemetrySample& sample) noexcept {
  sample.sceneRevision = state.sceneRevision;
  sample.adoptionTick = state.adoptionTick;
  sample.hip = state.measuredHip;
  sample.foreseenHip = state.hip;
  sample.ihip = contact.touching ? contact.ihip : state.measuredHip;
  sample.object = state.contactObject;
  sample.primitive = {contact.primitive.kind, contact.primitive.localIndex, contact.primitive.polygon};
  sample.penetration_m = contact.penetration_m;
  sample.surfaceNormal = contact.normal;
  sample.force.spring = force.spring;
  sample.force.damping = force.damping;
  sample.force.friction = force.friction;
  sample.force.texture = force.texture;
  sample.force.contact = force.contact;
  sample.force.written = force.written;
  sample.contactEnergy_J = state.contactEnergy_J;
  sample.fault = state.fault;
}

void describeEnergy(const SurfaceMemory& surface, TelemetrySample& sample) noexcept {
  sample.shadingEnergy_J = surface.shadingEnergy_J;
  sample.frictionEnergy_J = surface.frictionEnergy_J;
  sample.textureEnergy_J = surface.textureEnergy_J;
}

/// The step, for scenes in which some object has surface properties or moves, and for those without, where they cost nothing: for
/// that its stages are inlined into both.
template <bool kDetails>
[[nodiscard, gnu::always_inline]] inline TelemetrySample step(const ServoScene& scene, HapticState& state,
                                                              const StepConfig& config,
                                                              const StepInput& input) noexcept {
  TelemetrySample sample;
  sample.tick = input.tick;
  sample.time_ns = input.time_ns;
  sample.deviceState = input.device.state;
  sample.device = input.device.status;
  ContactResult contact;
  ForceComponents force;
  Vec3 geometricNormal(0);  // the details turn the other one

  supervise(state, config, input);
  const bool anyMoves = kDetails && state.movingCount > 0;
  if (anyMoves) [[unlikely]]
    takeMovedPoses(state);
  if (state.fault == Fault::kNone) {
    followHip(state, input.device.position);
    moveEdited(state, config);

    followContact({state.bodies.data(), state.bodyCount}, state.contact, state.hip, contact);
    if (contact.work.putOut) [[unlikely]]
      state.adoptedNow = state.contactBroken = true;  // blended as an edit's jump is
    if constexpr (kDetails) {
      if (state.anySoft) [[unlikely]]
        yieldToContact(scene, state, config, contact);
    }
    if (state.lead.active()) geometricNormal = contact.normal;
    if constexpr (kDetails) {
      feelDetails(scene, state, config, contact, sample);
      force = sample.force;
    } else {
      feelSurfaces(scene, state, config, contact, force);
    }
  }
  force.contact = force.spring + force.damping + force.friction + force.texture;
  const std::uint64_t touched = contact.touching ? scene.objects[static_cast<std::size_t>(contact.body)].id : 0;
  limitForce(state, config, touched, force);
  if (anyMoves) [[unlikely]]
    moveBodies(state, config, contact, force.contact);

  state.contactObject = touched;
  state.written_N = force.written;
  if (state.lead.active()) {
    state.lead.note(force.written, geometricNormal,
                    surfaceSpeed(state, contact.body, contact.ihip, geometricNormal, config));
  }
  state.adoptedNow = state.contactBroken = state.detailEdited = false;
  describe(state, contact, force, sample);
  if constexpr (kDetails) {
    describeEnergy(state.surface, sample);
    sample.deformationRevision = state.deformationRevision;
  }
  return sample;
}

[[gnu::noinline]] TelemetrySample stepWithDetails(const ServoScene& scene, HapticState& state, const StepConfig& config,
                                                  const StepInput& input) noexcept {
  return step<true>(scene, state, config, input);
}

}  // namespace

TelemetrySample hapticStep(const ServoScene& scene, HapticState& state, const StepConfig& config,
                           const StepInput& input) noexcept {
  if (state.anyDetail) [[unlikely]]
    return stepWithDetails(scene, state, config, input);
  return step<false>(scene, state, config, input);
}

}  // namespace haptics

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>

#include "common/deform/dent.h"
#include "common/deform/soft_tissue.h"
#include "common/telemetry/telemetry_sample.h"
#include "haptic_server/contact/contact.h"
#include "haptic_server/force/lead_observer.h"
#include "haptic_server/force/output_chain.h"
#include "haptic_server/force/spring_damper.h"
#include "haptic_server/force/velocity_estimator.h"
#include "haptic_server/servo/energy_account.h"
#include "haptic_server/servo/servo_scene.h"
#include "haptic_server/servo/surface_memory.h"
#include "haptic_server/surface/force_shading.h"

namespace haptics {

/// No device reaches as far, and no scene. Fields and searches count in steps that are fine against it.
inline constexpr double kFarthest_m = 1e4;

/// Whether something can be there, world or object frame: finite, and no farther than kFarthest_m.
[[nodiscard]] inline bool isPlace(Vec3 v) noexcept {
  return squaredLength(v) <= kFarthest_m * kFarthest_m;  // not for NaN
}

/// With it the slowest tick that haptic_eval worst found at 1 kHz took 226 us (AMD EPYC, 2.4 GHz). Less makes dense scenes
/// slower to go through; more leaves less time to everything else.
inline constexpr double kWork_per_s = 270e6;

/// Fixed for a session.
struct StepConfig {
  double period_s = 1e-3;     ///< Nominal tick, used by every integration: never the measured one.
  double maxForce_N = 3.3;    ///< Magnitude limit, the device's.
  double positionStep_m = 0;  ///< Of the device's encoders.
  /// Largest lateral stiffness at which the device is locally stable: textures and friction stay below.
  double stableLateral_N_per_m = std::numeric_limits<double>::infinity();
  /// Contact and force are computed where the observer sees the HIP coming; at the measured HIP where there is none.
  std::optional<LeadSettings> lead = std::nullopt;
  /// What the queries of a tick may cost (Allowance), by time: infinite for as much as they take. Besides, an adoption may
  /// take a third of it, whose tick has a half, and rehearsals of the tick and the bodies' planes a quarter each.
  double work_per_s = kWork_per_s;
  /// Seconds in which the force comes after the device was attached or homed, or a fault is over; 0: at once.
  double rise_s = 0;

  [[nodiscard]] Allowance allowance() const noexcept {
    constexpr double kEndless = 1e18;
    const double units = work_per_s * period_s;
    return units < kEndless ? Allowance(static_cast<std::int64_t>(units)) : Allowance();
  }
};

/// What the servo remembers from tick to tick, but for the bodies. Written by the step, stage by stage, unless noted.
struct StepMemory {
  // Written by adoptScene().
  std::uint64_t sceneRevision = 0;
  std::uint64_t adoptionTick = 0;
  std::size_t bodyCount = 0;
  bool adoptedNow = false;  ///< Until the end of the tick of an adoption.
  /// The adoption could not carry the contact on as it was, or a body has come in between in a dent.
  bool contactBroken = false;
  bool detailEdited = false;  ///< The adoption changed what the felt surface feels like, or where it is.
  std::size_t movingCount = 0;
  std::size_t nextToMove = 0;             ///< Of the moving bodies, where they move in turn. Written by the step.
  std::size_t dentCount = 0;              ///< Written by the step, as are the next two.
  std::uint64_t deformationRevision = 0;  ///< Counts the ticks in which some dent changed. Written by the step.
  std::uint64_t dentNumber = 0;           ///< Of the newest dent. Written by the step.
  bool anyDetail = false;                 ///< Some object of the scene has surface properties, moves, or is soft;
  bool anySoft = false;                   ///< Some is soft;
  bool anyBumps = false;                  ///< bumps that are felt outside of its polygons;
  bool anyVaryingStiffness = false;       ///< a stiffness that varies over its surface.
  bool anyBeingMoved = false;
  bool anyLeaving = false;
  bool lettingGo = false;  ///< An adoption that would break the contact waits for it to fade.
  double letGo_s = 0;      ///< For so long. Written by the step.

  Allowance allowance;  ///< Of each tick; of the config.
  bool attached = false;
  VelocityEstimator velocity;
  ContactState contact;
  /// The surfaces that hold the IHIP, as force shading has them, where several bodies do. Of the tick.
  struct Groove {
    bool shaded = false;
    std::array<Vec3, ContactState::kMaxHolding> normal{Vec3(0), Vec3(0), Vec3(0)};  ///< Outward, unit, world.
  } groove;
  std::uint64_t contactObject = 0;  ///< Id, 0 when free.
  std::uint64_t behind = 0;         ///< Ticks that spent their allowance.
  std::uint64_t putOut = 0;         ///< Times that the IHIP was put out of a body;
  std::uint64_t putOutOf = 0;       ///< id of the last one.
  EditSlew slew;
  FaultRamp faultRamp;
  DeadlineWatch deadlines;
  Fault fault = Fault::kNone;
  Vec3 measuredHip{0};
  Vec3 hip{0};          ///< Where contact and force are computed: measuredHip, or what the observer makes of it.
  Vec3 unlimited_N{0};  ///< Before fault ramp and, unless an edit is felt, limit.
};

/// A body that has a motion.
struct MovingBody {
  std::size_t body = 0;             ///< Index into bodies. Written by adoptScene(), as is the next;
  const RigidBody* what = nullptr;  ///< of the scene.
  RigidState state;
  bool moved = false;        ///< In the last tick: it has a new pose.
  std::uint16_t waited = 0;  ///< Ticks since, where bodies move in turn.

  /// Of another: where it is, and how much there is to its motion.
  void copyPlace(const MovingBody& other) noexcept {
    body = other.body;
    what = other.what;
    moved = other.moved;
    waited = other.waited;
    state.rest = other.state.rest;
    state.centre_m = other.state.centre_m;
    state.axes = other.state.axes;
    state.coordinate = other.state.coordinate;
    state.touchingCount = other.state.touchingCount;
    state.condition = other.state.condition;
  }
};

/// A dent in a soft body.
struct BodyDent {
  std::size_t body = 0;  ///< Index into bodies.
  Dent dent;
  Dent rest;                 ///< What it comes to once nothing presses it: of no depth unless it is plastic.
  Dent begun;                ///< While it is pressed: what is to stay where this stretch of its way began.
  std::uint64_t number = 0;  ///< Counts up from 1. An object's dents are in order of it.
  double still_s = 0;        ///< So long it has been what it comes to.
  double kept_m = 0;     ///< While it is pressed: of its depth, what had stayed before, so that nobody pressed for it.
  bool pressed = false;  ///< By the contact: one of each body that holds the IHIP, at most.
  bool stays = false;    ///< It will not change any more; the builder may take it in.
};

/// Everything the servo remembers from tick to tick. A copy of it goes on exactly like the original.
struct HapticState : StepMemory {
  explicit HapticState(const StepConfig& config) noexcept {
    allowance = config.allowance();
    velocity = VelocityEstimator(config.period_s);
    if (config.lead) lead = LeadObserver(*config.lead, config.period_s);
  }

  /// The allowance did not last for all that is felt: the tick is counted, and the step of the force slewed.
  [[gnu::cold]] void fallBehind(ContactWork& work) noexcept {
    if (!work.behind) ++behind;
    work.behind = true;
    slew.begin();
  }

  /// Becomes a copy of another, which goes on exactly like it, without copying the places beyond its bodyCount.
  void copyInUse(const HapticState& other) noexcept {
    static_cast<StepMemory&>(*this) = other;
    std::copy_n(other.bodies.begin(), bodyCount, bodies.begin());
    std::copy_n(other.objects.begin(), bodyCount, objects.begin());
    if (anyDetail) surface = other.surface;
    std::copy_n(other.moving.begin(), movingCount, moving.begin());
    if (other.lead.active()) lead.copyInUse(other.lead);
    energy.copyInUse(other.energy);
    std::copy_n(other.dents.begin(), dentCount, dents.begin());
    if (anyBumps) std::copy_n(other.bumps.begin(), bodyCount, bumps.begin());
  }

  /// Of a state that this one is a copy of, and that has gone on since without an adoption or an edit under the stylus: as
  /// much of it as a rehearsal of its next tick needs. What objects at rest feel like is left as this one has it.
  void copyForRehearsal(const HapticState& other) noexcept {
    static_cast<StepMemory&>(*this) = other;
    if (anyDetail) surface = other.surface;
    for (std::size_t i = 0; i < movingCount; ++i) {
      moving[i].copyPlace(other.moving[i]);
      bodies[moving[i].body] = other.bodies[moving[i].body];
    }
    if (other.lead.active()) lead.copyInUse(other.lead);
    energy.copyInUse(other.energy);
    std::copy_n(other.dents.begin(), dentCount, dents.begin());
  }

  /// One object's lasting state, carried over adoptions by id.
  struct ObjectState {
    std::uint64_t id = 0;
    Pose scenePose;                  ///< As in the scene; setting it, also to the same, resets the body's motion.
    std::uint64_t poseRevision = 0;  ///< Likewise.
    bool beingMoved = false;         ///< Edited under the stylus: on its way to scenePose.
    FeltStiffness felt;
    const SurfaceDetail* detail = nullptr;  ///< As in the scene, to tell whether it was edited.
    const SoftTissue* tissue = nullptr;     ///< Likewise.
    double highestFactor = 0;               ///< Likewise.
    TakenDents taken;                       ///< As in the scene.
  };

  /// Of a soft body that holds the IHIP alone, in this tick. Written by yieldToContact(), where some body is soft.
  struct Yielded {
    ShadedPoint shaded;    ///< Yielding::smooth();
    Vec3 foot{0};          ///< Yielding::foot().
    bool isLevel = false;  ///< No other dents are there: from the foot to the IHIP the surface has not turned.
    bool between = false;  ///< Another body holds the dent up.
  } yielded;
  LeadObserver lead;  ///< Where it is active, `velocity` is its.
  // Written by adoptScene(), in the order of the scene's objects; poses of moving bodies by the step.
  std::array<Body, kMaxServoObjects> bodies;
  std::array<ObjectState, kMaxServoObjects> objects;
  std::array<BumpWatch, kMaxServoObjects> bumps;
  std::array<MovingBody, kMaxMovingBodies> moving;
  std::array<BodyDent, kMaxDents> dents;

  [[nodiscard]] std::span<const BodyDent> allDents() const noexcept { return std::span(dents).first(dentCount); }
  /// What the contact pressed in is left to go back.
  void release() noexcept {
    for (std::size_t i = 0; i < dentCount; ++i) dents[i].pressed = false;
  }

  SurfaceMemory surface;
  EnergyAccount energy;
};

/// Where a body was when the contact core met it last: at the last tick, or within its motion then, where that tick spent
/// its allowance on the way (ContactState::reached).
[[nodiscard]] inline Pose lastTestedPose(const HapticState& state, const Body& body) noexcept {
  const double reached = state.contact.reached;
  return reached < 1 ? interpolate(body.previous, body.current, reached) : body.current;
}

static_assert(std::is_trivially_copyable_v<HapticState>, "copied to replay and to compare runs");

}  // namespace haptics

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
#include <type_traits>

#include "common/deform/dent.h"
#include "common/deform/soft_tissue.h"
#include "common/telemetry/telemetry_sample.h"
#include "haptic_server/collision/body_pairs.h"
#include "haptic_server/contact/contact.h"
#include "haptic_server/force/device_torque.h"
#include "haptic_server/force/output_chain.h"
#include "haptic_server/force/predictive_observer.h"
#include "haptic_server/force/spring_damper.h"
#include "haptic_server/force/velocity_estimator.h"
#include "haptic_server/step/energy_account.h"
#include "haptic_server/step/servo_scene.h"
#include "haptic_server/step/surface_memory.h"
#include "haptic_server/surface/force_shading.h"
#include "haptic_server/tool/tool_contact.h"

namespace haptics {

/// No device reaches as far, and no scene. Fields and searches count in steps that are fine against it.
inline constexpr double kFarthest_m = 1e4;

/// Whether something can be there, world or object frame: finite, and no farther than kFarthest_m.
[[nodiscard]] inline bool isWithinWorld(Vec3 v) noexcept {
  return squaredLength(v) <= kFarthest_m * kFarthest_m;  // not for NaN
}

/// With it the slowest ticks that haptic_eval worst found (tests/eval/worst/kept.json) end within 250 us at 1 kHz (AMD EPYC,
/// 2.4 GHz). Less makes dense scenes slower to go through; more leaves less time to everything else.
inline constexpr double kWork_per_s = 250e6;

/// Fixed for a session.
struct StepConfig {
  double period_s = 1e-3;     ///< Nominal tick, used by every integration: never the measured one.
  double maxForce_N = 3.3;    ///< Magnitude limit, the device's.
  double positionStep_m = 0;  ///< Of the device's encoders.
  /// Largest lateral stiffness at which the device is locally stable: textures and friction stay below.
  double stableLateral_N_per_m = std::numeric_limits<double>::infinity();
  /// Contact and force are computed where the observer sees the HIP coming; at the measured HIP where there is none.
  std::optional<ObserverSettings> observer = std::nullopt;
  /// What the queries of a tick may cost (Allowance), by time: infinite for as much as they take. Besides, an adoption may
  /// take a third of it, whose tick has a half, and rehearsals of the tick and the bodies' planes a quarter each.
  double work_per_s = kWork_per_s;
  RotationConfig rotation{};
  /// Seconds in which the force comes after the device was attached or homed, or a fault is over; 0: at once.
  double rise_s = 0;

  [[nodiscard]] Allowance allowance() const noexcept {
    constexpr double kEndless = 1e18;
    const double units = work_per_s * period_s;
    return units < kEndless ? Allowance(static_cast<std::int64_t>(units)) : Allowance();
  }
};

/// How the scene was adopted. Written by adoptScene(), `contactBroken` and `fadeOut_s` by the step too.
struct Adoption {
  std::uint64_t revision = 0;
  std::uint64_t tick = 0;
  std::size_t bodyCount = 0;
  bool now = false;  ///< Until the end of the tick of an adoption.
  /// The adoption could not carry the contact on as it was, or a body has come in between in a dent.
  bool contactBroken = false;
  bool detailEdited = false;  ///< The adoption changed what the felt surface feels like, or where it is.
  bool fadingOut = false;     ///< An adoption that would break the contact waits for it to fade.
  double fadeOut_s = 0;       ///< Seconds for which it has waited.
};

/// What some object of the scene has, so that the step passes over what none has.
struct SceneFeatures {
  bool detail = false;            ///< Surface properties, a motion, or it is soft; or a tool is felt.
  bool soft = false;              ///< It is soft.
  bool bumps = false;             ///< Bumps that are felt outside of its polygons.
  bool varyingStiffness = false;  ///< A stiffness that varies over its surface.
  bool beingMoved = false;        ///< Edited under the stylus, it is on its way.
  bool pendingRemoval = false;    ///< It leaves the scene, or is a tool, or was one whose torque fades.
  bool tool = false;              ///< The hand holds it, and feels through it.
  bool torqueFades = false;       ///< The hand held it, and feels its torque yet.
};

struct Supervision {
  bool attached = false;
  Fault fault = Fault::kNone;
  FaultRamp ramp;
  DeadlineWatch deadlines;
};

struct HipEstimate {
  VelocityEstimator velocity;
  Vec3 measured{0};
  Vec3 hip{0};  ///< Where contact and force are computed: measured, or what the observer makes of it.
};

/// What the contact core met.
struct ContactReport {
  std::uint64_t object = 0;          ///< Id of what was touched in the last tick, 0 when free.
  std::uint64_t allowanceSpent = 0;  ///< Ticks that spent their allowance, or had no room for all bodies that collide.
  std::uint64_t depenetrated = 0;    ///< Times that the IHIP was put out of a body;
  std::uint64_t depenetratedFrom = 0;  ///< id of the last one.
};

/// The surfaces that hold the IHIP, as force shading has them, where several bodies do. Of the tick.
struct Groove {
  bool shaded = false;
  std::array<Vec3, ContactState::kMaxHolding> normal{Vec3(0), Vec3(0), Vec3(0)};  ///< Outward, unit, world.
};

struct ForceLimits {
  EditSlew slew;
  Vec3 unlimited_N{0};  ///< Before fault ramp and, unless an edit is felt, limit.
};

/// Of HapticState::moving.
struct Motion {
  std::size_t count = 0;
  std::size_t next = 0;  ///< Where they move in turn.
  std::size_t collidingCount = 0;
  bool follows = false;  ///< The state of the first hand moves them (two_hands.h).
};

/// What the second hand does to the bodies that move, in this tick, by index into HapticState::moving. Written by
/// takePushes(), where there is a second hand.
struct OtherHand {
  bool any = false;
  std::array<Push, kMaxMovingBodies> push;
  std::array<bool, kMaxMovingBodies> awaits;  ///< An edit of its pose has not come to an end for the second hand.
};

/// A body that meets others. Written by adoptScene().
struct CollidingBody {
  std::size_t body = 0;  ///< Index into bodies.
  int moving = -1;       ///< Index into moving; -1: it stands still.
  const CollisionPoints* points = nullptr;
  bool isPut = false;  ///< By an edit, in this tick.
};

/// The tool that the hand holds, where the scene has one.
struct ToolInHand {
  std::size_t body = 0;  ///< Index into bodies. Written by adoptScene().
  bool isNew = false;    ///< It was not held before this tick.
  ToolContact contact;
  ToolResult felt;      ///< In this tick.
  DeviceTorque torque;  ///< And how the device is turned.

  void copyInUse(const ToolInHand& other) noexcept {
    body = other.body;
    isNew = other.isNew;
    contact.copyInUse(other.contact);
    felt = other.felt;
    torque = other.torque;
  }
};

/// Of HapticState::dents.
struct Denting {
  std::size_t count = 0;
  std::uint64_t revision = 0;  ///< Counts the ticks in which some dent changed.
  std::uint64_t newest = 0;    ///< Its number.
  bool isHeldUp = false;       ///< In this tick another body holds the dent of the contact up.
};

/// A body that has a motion.
struct MovingBody {
  std::size_t body = 0;             ///< Index into bodies. Written by adoptScene(), as is the next;
  const RigidBody* what = nullptr;  ///< of the scene.
  RigidState state;
  bool moved = false;        ///< In the last tick: it has a new pose.
  bool collides = false;     ///< It is one of HapticState::colliding. Written by adoptScene().
  std::uint16_t waited = 0;  ///< Ticks since, where bodies move in turn.

  /// Copies where another body is, and what its motion depends on.
  void copyMotion(const MovingBody& other) noexcept {
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
  Dent begun;                ///< While it is pressed: what is to stay where this stretch of its path began.
  std::uint64_t number = 0;  ///< Counts up from 1. An object's dents are in order of it.
  double still_s = 0;        ///< Seconds for which it has been what it comes to.
  double kept_m = 0;         ///< While it is pressed: the part of its depth that had stayed from before.
  bool pressed = false;      ///< By the contact: one of each body that holds the IHIP, at most.
  bool stays = false;        ///< It will not change any more; the builder may bake it.
};

/// Everything the servo remembers from tick to tick. A copy of it goes on exactly like the original.
struct HapticState {
  explicit HapticState(const StepConfig& config) noexcept {
    allowance = config.allowance();
    estimate.velocity = VelocityEstimator(config.period_s);
    if (config.observer) observer = PredictiveObserver(*config.observer, config.period_s);
    tool.torque = DeviceTorque(config.rotation, config.period_s);
  }

  /// The allowance did not last for all that is felt: the tick is counted, and the step of the force slewed.
  [[gnu::cold]] void fallBehind(ContactWork& work) noexcept {
    if (!work.allowanceSpent) ++report.allowanceSpent;
    work.allowanceSpent = true;
    limits.slew.begin();
  }

  /// The parts that are copied and recorded whole, beside the contact; `State` is a HapticState, or a const one.
  template <class State>
  [[nodiscard]] static auto partsOf(State& state) noexcept {
    return std::tie(state.adoption, state.features, state.motion, state.denting, state.supervision, state.estimate,
                    state.report, state.groove, state.limits);
  }

  /// Becomes a copy of another, which goes on exactly like it, without copying the places beyond its counts.
  void copyInUse(const HapticState& other) noexcept {
    copyForEveryTick(other);
    std::copy_n(other.bodies.begin(), adoption.bodyCount, bodies.begin());
    std::copy_n(other.objects.begin(), adoption.bodyCount, objects.begin());
    std::copy_n(other.moving.begin(), motion.count, moving.begin());
    if (features.bumps) std::copy_n(other.bumps.begin(), adoption.bodyCount, bumps.begin());
    std::copy_n(other.colliding.begin(), motion.collidingCount, colliding.begin());
    pairs.copyInUse(other.pairs);
    if (features.tool) tool.copyInUse(other.tool);
  }

  /// Of a state that this one is a copy of, and that has gone on since without an adoption or an edit under the stylus: as
  /// much of it as a rehearsal of its next tick needs. What objects at rest feel like is left as this one has it.
  void copyForRehearsal(const HapticState& other) noexcept {
    copyForEveryTick(other);
    for (std::size_t i = 0; i < motion.count; ++i) {
      moving[i].copyMotion(other.moving[i]);
      bodies[moving[i].body] = other.bodies[moving[i].body];
    }
  }

  /// One object's lasting state, carried over adoptions by id.
  struct ObjectState {
    std::uint64_t id = 0;
    Pose scenePose;                  ///< As in the scene; setting it, also to the same, resets the body's motion.
    std::uint64_t poseRevision = 0;  ///< Likewise.
    bool beingMoved = false;         ///< Edited under the stylus: on its way to scenePose.
    RateLimitedStiffness stiffness;
    const SurfaceDetail* detail = nullptr;  ///< As in the scene, to tell whether it was edited.
    const SoftTissue* tissue = nullptr;     ///< Likewise.
    double highestFactor = 0;               ///< Likewise.
    BakedDents baked;                       ///< As in the scene.
  };

  /// The contact on a soft body that holds the IHIP alone, in this tick. Written by deformAtContact(), where some body
  /// is soft.
  struct DeformedContact {
    ShadedPoint shaded;    ///< DentSolver::smooth();
    Vec3 foot{0};          ///< DentSolver::foot().
    bool isLevel = false;  ///< No other dents are there: from the foot to the IHIP the surface has not turned.
  } deformedContact;
  [[nodiscard]] std::span<const BodyDent> allDents() const noexcept { return std::span(dents).first(denting.count); }
  /// The contact's dents are pressed no longer: they go back.
  void release() noexcept {
    for (std::size_t i = 0; i < denting.count; ++i) dents[i].pressed = false;
  }

  // What every tick reads comes first, and together.
  Adoption adoption;
  SceneFeatures features;
  Motion motion;
  Denting denting;
  Allowance allowance;  ///< Of each tick; of the config.
  HipEstimate estimate;
  ContactState contact;
  Groove groove;
  ContactReport report;
  ForceLimits limits;
  Supervision supervision;
  PredictiveObserver observer;  ///< Where it is active, the estimate's velocity is the observer's.
  // In the order of the scene's objects. Written by adoptScene(), poses of moving bodies by the step.
  std::array<Body, kMaxServoObjects> bodies;
  std::array<ObjectState, kMaxServoObjects> objects;
  std::array<BumpState, kMaxServoObjects> bumps;
  std::array<MovingBody, kMaxMovingBodies> moving;
  OtherHand otherHand;
  std::array<CollidingBody, kMaxColliders> colliding;
  BodyPairs pairs;
  std::array<BodyDent, kMaxDents> dents;
  SurfaceMemory surface;
  EnergyAccount energy;
  ToolInHand tool;

 private:
  void copyForEveryTick(const HapticState& other) noexcept {
    partsOf(*this) = partsOf(other);
    allowance = other.allowance;
    contact = other.contact;
    if (features.detail) surface = other.surface;
    if (other.observer.active()) observer.copyInUse(other.observer);
    energy.copyInUse(other.energy);
    std::copy_n(other.dents.begin(), denting.count, dents.begin());
  }
};

/// Where a body was when the contact core met it last: at the last tick, or within its motion then, where that tick spent
/// its allowance on the way (ContactState::reached).
[[nodiscard]] inline Pose lastTestedPose(const HapticState& state, const Body& body) noexcept {
  const double reached = state.contact.reached;
  return reached < 1 ? interpolate(body.previous, body.current, reached) : body.current;
}

static_assert(std::is_trivially_copyable_v<HapticState>, "copied to replay and to compare runs");

}  // namespace haptics

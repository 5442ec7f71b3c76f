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
#include "haptic_server/engine/collision/body_pairs.h"
#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/contact/fast_path/contact_cache.h"
#include "haptic_server/engine/force/device_torque.h"
#include "haptic_server/engine/force/output_chain.h"
#include "haptic_server/engine/force/predictive_observer.h"
#include "haptic_server/engine/force/spring_damper.h"
#include "haptic_server/engine/force/velocity_estimator.h"
#include "haptic_server/engine/step/energy_account.h"
#include "haptic_server/engine/step/servo_scene.h"
#include "haptic_server/engine/step/surface_memory.h"
#include "haptic_server/engine/surface/force_shading.h"
#include "haptic_server/engine/tool/tool_contact.h"

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
  double maxGrip_Nm = 0;  ///< Magnitude limit of the moment on the device's gripper; 0: it gives none.
  /// Seconds in which the force comes after the device was attached or homed, or a fault is over; 0: at once.
  double rise_s = 0;

  [[nodiscard]] Allowance allowance() const noexcept {
    constexpr double kEndless = 1e18;
    const double units = work_per_s * period_s;
    return units < kEndless ? Allowance(static_cast<std::int64_t>(units)) : Allowance();
  }
};

/// How the scene was adopted. Written by adoptScene(), `fadeOut_s` by the step too.
struct Adoption {
  std::uint64_t revision = 0;
  std::uint64_t tick = 0;
  Word<bool> fadingOut = false;  ///< An adoption that would break the contact waits for it to fade.
  double fadeOut_s = 0;          ///< Seconds for which it has waited.

  HAPTICS_FIELDS(self.revision, self.tick, self.fadingOut, self.fadeOut_s);
};

struct Supervision {
  Word<bool> attached = false;
  Word<Fault> fault = Fault::kNone;
  FaultRamp ramp;
  DeadlineWatch deadlines;

  HAPTICS_FIELDS(self.attached, self.fault, self.ramp, self.deadlines);
};

struct HipEstimate {
  VelocityEstimator velocity;
  Vec3 measured{0};
  Vec3 hip{0};  ///< Where contact and force are computed: measured, or what the observer makes of it.

  HAPTICS_FIELDS(self.velocity, self.measured, self.hip);
};

/// What the contact core met.
struct ContactReport {
  std::uint64_t object = 0;          ///< Id of what was touched in the last tick, 0 when free.
  std::uint64_t allowanceSpent = 0;  ///< Ticks that spent their allowance, or had no room for all bodies that collide.
  std::uint64_t depenetrated = 0;    ///< Times that the IHIP was put out of a body;
  std::uint64_t depenetratedFrom = 0;  ///< id of the last one.

  HAPTICS_FIELDS(self.object, self.allowanceSpent, self.depenetrated, self.depenetratedFrom);
};

struct ForceLimits {
  EditSlew slew;
  Vec3 unlimited_N{0};  ///< Before fault ramp and, unless an edit is felt, limit.
  /// Where there are effects: what device or clutch leave of what is felt, before the slew; 1 where that did nothing.
  double within = 1;
  Word<bool> clutched = false;  ///< In this tick: nothing is felt.

  HAPTICS_FIELDS(self.slew, self.unlimited_N, self.within, self.clutched);
};

/// How the bodies in StateFields::moving are moved.
struct Motion {
  std::uint64_t next = 0;      ///< Where they move in turn.
  Word<bool> follows = false;  ///< The state of the first hand moves them (two_hands.h).

  HAPTICS_FIELDS(self.next, self.follows);
};

/// Counters of StateFields::dents.
struct Denting {
  std::uint64_t revision = 0;   ///< Counts the ticks in which some dent changed.
  std::uint64_t newest = 0;     ///< Its number.
  Word<bool> isHeldUp = false;  ///< In the last tick another body held the dent of the contact up.

  HAPTICS_FIELDS(self.revision, self.newest, self.isHeldUp);
};

/// Of an object that is driven (kinematic_motion.h).
struct KinematicMotion {
  std::uint64_t number = 0;  ///< KinematicPose::number of the newest sample; 0: it is not driven.
  std::uint64_t since = 0;   ///< Ticks since that came,
  std::uint64_t begun = 0;   ///< since the first of the stream came,
  double left = 0;           ///< and until the object is there.

  HAPTICS_FIELDS(self.number, self.since, self.begun, self.left);
};

/// Of an object whose vertices are moved (kinematic_motion.h).
struct ShapeMotion {
  std::uint64_t number = 0;  ///< KinematicShape::number of the newest sample; 0: there is none.
  std::uint64_t since = 0;   ///< Ticks since that came,
  std::uint64_t begun = 0;   ///< since the first of the stream came,
  double left = 0;           ///< and until the shape is that.
  double along = 0;          ///< Where it is on its way over the samples (ShapeMemory::moveTo()).

  HAPTICS_FIELDS(self.number, self.since, self.begun, self.left, self.along);
};

/// One object's lasting state, carried over adoptions by id.
struct ObjectState {
  std::uint64_t id = 0;
  Pose scenePose;                     ///< As in the scene; setting it, also to the same, resets the body's motion.
  std::uint64_t poseRevision = 0;     ///< Likewise.
  Pose previous, current;             ///< Of Body.
  Word<bool> pendingRemoval = false;  ///< Of Body.
  Word<bool> beingMoved = false;      ///< Edited under the stylus: on its way to scenePose.
  RateLimitedStiffness stiffness;

  HAPTICS_FIELDS(self.id, self.scenePose, self.poseRevision, self.previous, self.current, self.pendingRemoval,
                 self.beingMoved, self.stiffness);
};

/// A body that has a motion.
struct MovingBody {
  std::uint64_t body = 0;  ///< Index into objects. Written by adoptScene().
  RigidState state;
  Word<bool> moved = false;  ///< In the last tick: it has a new pose.
  std::uint64_t waited = 0;  ///< Ticks since, where bodies move in turn.
  Vec3 effectsRest_N{0};     ///< What effects in its frame, now or before an edit, have of the rest of EditSlew; world.

  HAPTICS_FIELDS(self.body, self.state, self.moved, self.waited, self.effectsRest_N);

  /// Copies where another body is, and what its motion depends on.
  void copyMotion(const MovingBody& other) noexcept {
    body = other.body;
    moved = other.moved;
    waited = other.waited;
    effectsRest_N = other.effectsRest_N;
    state.rest = other.state.rest;
    state.centre_m = other.state.centre_m;
    state.axes = other.state.axes;
    state.coordinate = other.state.coordinate;
    state.touching.count = other.state.touching.count;
    state.condition = other.state.condition;
  }
};

/// A dent in a soft body.
struct BodyDent {
  std::uint64_t body = 0;  ///< Index into objects.
  Dent dent;
  Dent rest;                   ///< What it comes to once nothing presses it: of no depth unless it is plastic.
  Dent begun;                  ///< While it is pressed: what is to stay where this stretch of its path began.
  std::uint64_t number = 0;    ///< Counts up from 1. An object's dents are in order of it.
  double still_s = 0;          ///< Seconds for which it has been what it comes to.
  double kept_m = 0;           ///< While it is pressed: the part of its depth that had stayed from before.
  Word<bool> pressed = false;  ///< By the contact: one of each body that holds the IHIP, at most.
  Word<bool> stays = false;    ///< It will not change any more; the builder may bake it.

  HAPTICS_FIELDS(self.body, self.dent, self.rest, self.begun, self.number, self.still_s, self.kept_m, self.pressed,
                 self.stays);
};

/// The tool that the hand holds, where the scene has one.
struct ToolInHand {
  std::uint64_t body = 0;          ///< Index into objects. Written by adoptScene().
  Word<bool> isNew = false;        ///< It has not come to the device yet.
  Word<bool> nextPressed = false;  ///< The button for the next one was, in the last tick.
  ToolMemory memory;
  DeviceTorque torque;       ///< And how the device is turned.
  Word<bool> grips = false;  ///< It has jaws, or one that had some was held and its moment fades.
  DeviceTorque grip;         ///< Of the gripper, and how far that is open.

  HAPTICS_FIELDS(self.body, self.isNew, self.nextPressed, self.memory, self.torque, self.grips, self.grip);
};

/// What the hand holds by a button (grasp.h).
struct Grasp {
  std::uint64_t object = 0;    ///< Its id; 0: nothing.
  std::uint64_t moving = 0;    ///< Its index into StateFields::moving.
  Vec3 place{0};               ///< Where the hand holds it; object frame, m.
  Quat turned{1, 0, 0, 0};     ///< How it was turned when it was taken, seen from the device.
  Quat device{1, 0, 0, 0};     ///< How the device was turned in the last tick; world.
  Word<bool> pressed = false;  ///< The button was, in the last tick.

  HAPTICS_FIELDS(self.object, self.moving, self.place, self.turned, self.device, self.pressed);
};

/// The surfaces that hold the IHIP, as force shading has them, where several bodies do.
struct Groove {
  Word<bool> shaded = false;
  std::array<Vec3, ContactState::kMaxHolding> normal{Vec3(0), Vec3(0), Vec3(0)};  ///< Outward, unit, world.

  HAPTICS_FIELDS(self.shaded, self.normal);
};

/// What some object of the scene has, so that the step passes over what none has.
struct SceneFeatures {
  Word<bool> detail = false;            ///< Surface properties, a motion, or it is soft; or a tool is felt.
  Word<bool> soft = false;              ///< It is soft.
  Word<bool> bumps = false;             ///< Bumps that are felt outside of its polygons.
  Word<bool> varyingStiffness = false;  ///< A stiffness that varies over its surface.
  Word<bool> beingMoved = false;        ///< Edited under the stylus, it is on its way; or it is being driven.
  /// It leaves the scene, or is a tool, or was one whose torque fades; or effects, or a grasp.
  Word<bool> extras = false;
  Word<bool> effects = false;      ///< It carries one, or has a tap; or what an edit took away has not faded yet.
  Word<bool> taps = false;         ///< It has a tap, or one that has left has not faded yet.
  Word<bool> tool = false;         ///< The hand holds it, and feels through it.
  Word<bool> torqueFades = false;  ///< The hand held it, or holds a body or did, and feels its torque yet.
  Word<bool> grasp = false;        ///< A button that grasps is pressed, or was in the last tick.

  HAPTICS_FIELDS(self.detail, self.soft, self.bumps, self.varyingStiffness, self.beingMoved, self.extras, self.effects,
                 self.taps, self.tool, self.torqueFades, self.grasp);
};

/// Everything the servo remembers from tick to tick, beside the scene that it has adopted and the configuration. A copy of it
/// goes on exactly like the original.
struct StateFields {
  Adoption adoption;
  SceneFeatures features;
  Motion motion;
  Denting denting;
  HipEstimate estimate;
  ContactState contact;
  Groove groove;
  ContactReport report;
  ForceLimits limits;
  Supervision supervision;
  PredictiveObserver observer;  ///< Where it is active, the estimate's velocity is the observer's.
  EnergyAccount energy;
  Sequence<BodyDent, kMaxDents> dents;
  SurfaceMemory surface;
  Sequence<MovingBody, kMaxMovingBodies> moving;
  Sequence<ObjectState, kMaxServoObjects> objects;  ///< In the order of the scene's.
  Sequence<BumpState, kMaxServoObjects> bumps;      ///< Of all objects, where one has some.
  BodyPairs pairs;
  ToolInHand tool;
  Grasp grasp;
  /// Of all objects, where one was driven since the scene set its pose.
  Sequence<KinematicMotion, kMaxServoObjects> driven;
  Sequence<ShapeMotion, kMaxServoObjects> reshaped;  ///< Of all objects, where the vertices of one are moved.
  Sequence<EffectMemory, kMaxEffects> effects;       ///< In the order of the scene's.
  TextureMemory texture;

  HAPTICS_FIELDS(self.adoption, self.features, self.motion, self.denting, self.estimate, self.contact, self.groove,
                 self.report, self.limits, self.supervision, self.observer, self.energy, self.dents, self.surface,
                 self.moving, self.objects, self.bumps, self.pairs, self.tool, self.grasp, self.driven, self.reshaped,
                 self.effects, self.texture);
};
static_assert(fields::isListed<StateFields>(), "no pointer, no padding, every member in the list");
static_assert(std::is_trivially_copyable_v<StateFields>);

/// What the second hand does to the bodies that move, in this tick, by index into StateFields::moving. Written by
/// takePushes(), where there is a second hand.
struct OtherHand {
  bool any = false;
  std::array<Push, kMaxMovingBodies> push;
  std::array<bool, kMaxMovingBodies> awaits;  ///< An edit of its pose has not come to an end for the second hand.
};

/// A body that meets others.
struct CollidingBody {
  std::size_t body = 0;  ///< Index into objects.
  int moving = -1;       ///< Index into moving; -1: it stands still.
  const CollisionPoints* points = nullptr;
  bool isPut = false;  ///< By an edit, in this tick.
};

/// The contact on a soft body that holds the IHIP alone, in this tick. Written by deformAtContact(), where some body is soft.
struct DeformedContact {
  ShadedPoint shaded;    ///< DentSolver::smooth();
  Vec3 foot{0};          ///< DentSolver::foot().
  bool isLevel = false;  ///< No other dents are there: from the foot to the IHIP the surface has not turned.
};

/// All effects together, in the last tick that felt them; nothing where there are none.
struct EffectsFelt {
  Vec3 force_N{0};          ///< On the hand; world.
  Stiffness stiffness;      ///< The sum of all, felt or not.
  double carried_m = 0;     ///< The longest way by which a frame moved by itself, where the HIP was.
  double byTime_N = 0;      ///< EffectField::Felt::byTime_N of all.
  double withinBefore = 1;  ///< ForceLimits::within of the tick before.
};

/// What is so in this tick only: false before adoptScene(), and again at the tick's end.
struct TickEvents {
  bool adopted = false;
  /// The adoption could not carry the contact on as it was, or a body has come in between in a dent.
  bool contactBroken = false;
  bool effectsEdited = false;  ///< The adoption changed some effect, or what carries one has leapt.
  bool detailEdited = false;   ///< The adoption changed what the felt surface feels like, or where it is.
  bool clutchMoved = false;    ///< The hand took hold of its workspace, or let it go.
  bool takesNextTool = false;  ///< adoptScene() is to give the hand the tool after the one that it holds.
};

/// The state with what follows from it, from its scene and from the configuration, and what is of a tick.
struct HapticState : StateFields {
  explicit HapticState(const StepConfig& config) noexcept {
    allowance = config.allowance();
    estimate.velocity = VelocityEstimator(config.period_s);
    if (config.observer) observer = PredictiveObserver(*config.observer, config.period_s);
    tool.torque = DeviceTorque(config.rotation, config.period_s);
    tool.grip = DeviceTorque({.maxTorque_Nm = config.maxGrip_Nm}, config.period_s);
  }

  /// The allowance did not last for all that is felt: the tick is counted, and the step of the force slewed.
  [[gnu::cold]] void fallBehind(ContactWork& work) noexcept {
    if (!work.allowanceSpent) ++report.allowanceSpent;
    work.allowanceSpent = true;
    limits.slew.begin();
  }

  /// What follows from the fields and their scene, which outlives this, made anew. False: the fields are none of a state on
  /// this scene.
  [[nodiscard]] bool connect(const ServoScene& adopted) noexcept;

  /// Becomes a copy of another, which goes on exactly like it, without what is beyond its counts.
  void copyInUse(const HapticState& other) noexcept;
  /// Of a state that this one is a copy of, and that has gone on since without an adoption or an edit under the stylus: as
  /// much of it as a rehearsal of its next tick needs. What objects at rest feel like is left as this one has it.
  void copyForRehearsal(const HapticState& other) noexcept;

  [[nodiscard]] std::span<const BodyDent> allDents() const noexcept { return dents.all(); }
  [[nodiscard]] std::span<const Body> allBodies() const noexcept { return {bodies.data(), objects.count}; }
  [[nodiscard]] const RigidBody& rigidBody(const MovingBody& body) const noexcept {
    return *scene->objects[body.body].motion;
  }
  /// The contact's dents are pressed no longer: they go back.
  void release() noexcept {
    for (BodyDent& dent : dents.all()) dent.pressed = false;
  }
  /// Sets a body's poses (world), and what follows from them.
  void place(std::size_t i, const Pose& previous, const Pose& current) noexcept {
    objects[i].previous = bodies[i].previous = previous;
    objects[i].current = bodies[i].current = current;
    bodies[i].update();
  }
  [[nodiscard]] bool isDriven(std::size_t i) const noexcept { return driven.count > 0 && driven[i].number != 0; }
  [[nodiscard]] bool isReshaped(std::size_t i) const noexcept { return reshaped.count > 0 && reshaped[i].number != 0; }
  /// Is there more to a tick than contacts at rest? SceneFeatures::extras.
  [[nodiscard]] bool hasExtras() const noexcept {
    return features.tool || features.torqueFades || features.effects || features.grasp ||
           std::ranges::any_of(allBodies(), &Body::pendingRemoval);
  }
  void makeUntouchable(std::size_t i) noexcept { objects[i].pendingRemoval = bodies[i].pendingRemoval = true; }

  const ServoScene* scene = nullptr;  ///< That was adopted; null: none yet.
  Allowance allowance;                ///< Of each tick; of the config.
  std::array<Body, kMaxServoObjects> bodies;
  ContactCache contactCache;
  std::array<CollidingBody, kMaxColliders> colliding;
  std::size_t collidingCount = 0;
  std::array<bool, kMaxMovingBodies> collides;  ///< Of the bodies that move: some of `colliding` is it.
  ToolScratch toolScratch;

  TickEvents now;
  DeformedContact deformedContact;
  EffectsFelt effectsFelt;
  std::array<Vec3, kMaxEffects> effectsBefore_N;  ///< EffectMemory::force_N of the tick before. Of addEffectForces().
  /// By index into moving: what the effects that the adoption took from the body's frame gave the hand in the tick before.
  std::array<Vec3, kMaxMovingBodies> effectsTaken_N;
  OtherHand otherHand;
  ToolResult toolFelt;
  Vec3 graspTorque_Nm{0};  ///< On the hand, of what it holds.
};
static_assert(std::is_trivially_copyable_v<HapticState>, "copied to replay and to compare runs");

/// Where a body was when the contact core met it last: at the last tick, or within its motion then, where that tick spent
/// its allowance on the way (ContactState::reached).
[[nodiscard]] inline Pose lastTestedPose(const HapticState& state, const Body& body) noexcept {
  const double reached = state.contact.reached;
  return reached < 1 ? interpolate(body.previous, body.current, reached) : body.current;
}

}  // namespace haptics

#include "haptic_server/engine/step/moving_bodies.h"

#include <algorithm>
#include <new>

#include "common/maths/rotation.h"
#include "haptic_server/engine/collision/moving_together.h"
#include "haptic_server/engine/motion/rigid_motion.h"
#include "haptic_server/engine/step/effect_forces.h"
#include "haptic_server/engine/step/held_springs.h"
#include "haptic_server/engine/step/tool_step.h"

namespace haptics {
namespace {

/// The part of the tick's allowance that the bodies' motions may take in any case; beyond it they move in turn.
[[nodiscard]] std::int64_t motionUnits(const HapticState& state) noexcept { return state.allowance.left() / 2; }

/// One push of both, at the place of the first.
[[nodiscard]] Push sum(const Push& a, const Push& b) noexcept {
  if (!a.any()) return b;
  return {a.force_N + b.force_N, a.place_m, a.torque_Nm + b.torque_Nm + glm::cross(b.place_m - a.place_m, b.force_N)};
}

/// Of the contact's force: that was written.
[[nodiscard]] double writtenPart(const HapticState& state, const ForceResult& result) noexcept {
  return writtenFraction(result.force.written, result.adds ? state.limits.unlimited_N : result.force.contact);
}

/// What one body is given of the force on the hand; nothing in a fault, in which that may be no number.
class Reaction {
 public:
  Reaction(const HapticState& state, const ForceResult& result) noexcept
      : state_(state),
        contact_(result.contact),
        written_N_(result.force.written),
        touches_(contact_.touching && state.supervision.fault == Fault::kNone),
        force_N_(touches_ ? contactForce_N(state, result) : Vec3(0)),
        part_(touches_ ? writtenPart(state, result) : 1),
        any_(touches_ || state.features.effects) {}

  [[nodiscard]] Push on(std::size_t body) const noexcept { return withTouch(body, 1); }
  /// What of it the hand feels.
  [[nodiscard]] Push felt(std::size_t body) const noexcept { return withTouch(body, part_); }

 private:
  const HapticState& state_;
  const ContactResult& contact_;
  Vec3 written_N_;
  bool touches_;
  Vec3 force_N_;
  double part_;
  bool any_;

  [[nodiscard]] Push withTouch(std::size_t body, double part) const noexcept {
    if (!any_) return {};
    Push touch = ofTouch(body);
    touch.force_N *= part;
    touch.torque_Nm *= part;
    return state_.features.effects ? sum(touch, pushOfEffects(state_, body, written_N_)) : touch;
  }

  [[nodiscard]] Push ofTouch(std::size_t body) const noexcept {
    if (!touches_) return {};
    if (state_.features.tool) return pushOfTool(state_, body);
    Push push{ofPoint(body), contact_.ihip};
    if (state_.grasp.object != 0 && static_cast<std::size_t>(contact_.body) == body)
      push.torque_Nm = -state_.graspTorque_Nm;
    return push;
  }

  [[nodiscard]] Vec3 ofPoint(std::size_t body) const noexcept {
    const auto holding = state_.contact.surfaces();
    Vec3 own(0);
    Vec3 others(0);
    for (std::size_t k = 1; k < holding.size(); ++k) {
      if (holding[k].body == contact_.body) continue;
      const Vec3 part = partOf(state_, k, force_N_) * heldNormal(state_, k);
      others += part;
      if (static_cast<std::size_t>(holding[k].body) == body) own += part;
    }
    return static_cast<std::size_t>(contact_.body) == body ? others - force_N_ : -own;
  }
};

/// A body stands still while an edit under either hand brings it to its place.
[[nodiscard]] bool standsStill(const HapticState& state, std::size_t moving) noexcept {
  return state.objects[state.moving[moving].body].beingMoved || (state.otherHand.any && state.otherHand.awaits[moving]);
}

[[nodiscard]] Push pushOnto(const HapticState& state, const Reaction& reaction, std::size_t moving) noexcept {
  const Push own = reaction.on(state.moving[moving].body);
  return state.otherHand.any ? sum(own, state.otherHand.push[moving]) : own;
}

/// Calls pair(i, k) for each object that moves in both states: its index into a.moving, and into b.moving.
template <class Pair>
void forEachShared(const HapticState& a, const HapticState& b, Pair pair) noexcept {
  std::size_t k = 0;  // both are in order of the objects' ids
  for (std::size_t i = 0; i < a.moving.count; ++i) {
    const std::uint64_t id = a.objects[a.moving[i].body].id;
    while (k < b.moving.count && b.objects[b.moving[k].body].id < id) ++k;
    if (k < b.moving.count && b.objects[b.moving[k].body].id == id) pair(i, k);
  }
}

/// After a body's motion: attributes the work that it does on the hand with the force that is held meanwhile. One that is
/// stopped for good fades from under the hand.
void endMotion(HapticState& state, const MovingBody& moving, const Push& push) noexcept {
  if (push.any()) {
    const Pose& now = state.bodies[moving.body].current;
    const Vec3 way = toWorld(poseOf(state.rigidBody(moving), moving.state), toLocal(now, push.place_m)) - push.place_m;
    state.energy.attribute(state.objects[moving.body].id, EnergyFeature::kMotion, -glm::dot(push.force_N, way));
  }
  if (isStopped(moving.state.condition)) state.makeUntouchable(moving.body);
}

/// Of the origin, from one pose to the next.
[[nodiscard]] RigidVelocity velocityBetween(const Pose& before, const Pose& after, double period_s) noexcept {
  const Vec3 turn = rotationVector(after.rotation * glm::conjugate(before.rotation));
  return {(after.position - before.position) / period_s, turn / period_s};
}

[[nodiscard]] Collider colliderOf(HapticState& state, const CollidingBody& colliding, double period_s,
                                  const Reaction& reaction) noexcept {
  const Body& body = state.bodies[colliding.body];
  Collider collider{.surface = body.surface,
                    .points = colliding.points,
                    .pose = body.current,
                    .push = {},
                    .absent = body.pendingRemoval,
                    .isPut = colliding.isPut,
                    .isDriven = body.moving && state.isDriven(colliding.body)};
  if (collider.isDriven) collider.before = velocityBetween(body.previous, body.current, period_s);
  const auto moving = static_cast<std::size_t>(colliding.moving);
  if (colliding.moving < 0 || standsStill(state, moving)) return collider;
  collider.rigidBody = &state.rigidBody(state.moving[moving]);
  collider.state = &state.moving[moving].state;
  collider.pose = poseOf(*collider.rigidBody, *collider.state);
  collider.push = pushOnto(state, reaction, moving);
  return collider;
}

/// Bodies that meet one another, all in one tick. False: the allowance did not last, or there was no room for all.
bool moveCollidingBodies(HapticState& state, const StepConfig& config, const Reaction& reaction,
                         MotionAllowance& motion) noexcept {
  // Not initialised: to clear room for 256 takes longer than a few bodies do.
  union Room {
    Room() noexcept {}
    std::array<Collider, kMaxColliders> all;
  } room;
  const std::span<Collider> colliders = std::span(room.all).first(state.collidingCount);
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    new (&colliders[i]) Collider(colliderOf(state, state.colliding[i], config.period_s, reaction));
    state.colliding[i].isPut = false;
  }
  CollisionAllowance allowance{state.allowance, motion};
  const bool isWhole = moveTogether(colliders, state.pairs, config.period_s, allowance);
  motion = allowance.motion;
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    if (colliders[i].state == nullptr) continue;
    MovingBody& moving = state.moving[static_cast<std::size_t>(state.colliding[i].moving)];
    moving.moved = !(poseOf(*colliders[i].rigidBody, moving.state) == colliders[i].pose);
    endMotion(state, moving, reaction.felt(moving.body));
  }
  return isWhole;
}

}  // namespace

void takeMovedPoses(HapticState& state) noexcept {
  for (std::size_t i = 0; i < state.moving.count; ++i) {
    const MovingBody& moving = state.moving[i];
    if (state.objects[moving.body].beingMoved) continue;
    const Body& body = state.bodies[moving.body];
    if (!moving.moved && !body.moving) continue;
    const Pose previous = lastTestedPose(state, body);
    state.place(moving.body, previous, moving.moved ? poseOf(state.rigidBody(moving), moving.state) : body.current);
  }
}

std::int64_t unitsOfMotion(const HapticState& state) noexcept {
  if (state.motion.follows) return 0;
  std::int64_t units = 0;
  for (std::size_t i = 0; i < state.moving.count; ++i) {
    const MovingBody& moving = state.moving[i];
    if (moving.state.condition == BodyCondition::kAwake)
      units += leastMotionUnits(state.rigidBody(moving), moving.state);
  }
  if (state.collidingCount > 0) units += leastCollisionUnits(state.pairs);
  return std::min(units, motionUnits(state));
}

void moveBodies(HapticState& state, const StepConfig& config, const ForceResult& result) noexcept {
  if (state.motion.follows) return;
  const ContactResult& contact = result.contact;
  const Reaction reaction(state, result);
  const std::int64_t left = result.keptForMotion + std::max<std::int64_t>(0, contact.work.allowance.left());
  MotionAllowance allowance{Allowance(std::min(motionUnits(state), left)), Allowance(state.allowance.left() / 8)};
  if (state.collidingCount > 0 && !moveCollidingBodies(state, config, reaction, allowance) &&
      !contact.work.allowanceSpent)
    ++state.report.allowanceSpent;
  std::size_t next = 0;
  bool inTurn = false;
  for (std::size_t k = 0; k < state.moving.count; ++k) {
    const std::size_t i = (state.motion.next + k) % state.moving.count;
    MovingBody& moving = state.moving[i];
    if (state.collides[i]) continue;
    moving.moved = false;
    if (standsStill(state, i)) continue;
    const Push push = pushOnto(state, reaction, i);
    if (moving.state.condition != BodyCondition::kAwake && !push.any()) continue;
    if (k > 0 && !push.any() && allowance.least.left() < leastMotionUnits(state.rigidBody(moving), moving.state)) {
      if (!inTurn) next = i;
      inTurn = true;
      ++moving.waited;
      continue;
    }
    if (push.any() && moving.waited > 0) {  // the hand pushes it for this tick alone
      moveRigidBody(state.rigidBody(moving), moving.state, Push{}, config.period_s * static_cast<double>(moving.waited),
                    allowance);
      moving.waited = 0;
    }
    moveRigidBody(state.rigidBody(moving), moving.state, push, config.period_s * static_cast<double>(1 + moving.waited),
                  allowance);
    moving.waited = 0;
    moving.moved = true;
    endMotion(state, moving, reaction.felt(moving.body));
  }
  state.motion.next = next;
  state.otherHand.any = false;
}

void takePushes(HapticState& first, const HapticState& second, const ForceResult& secondResult) noexcept {
  if (first.moving.count == 0) return;
  OtherHand& other = first.otherHand;
  other.any = true;
  std::fill_n(other.push.begin(), first.moving.count, Push{});
  std::fill_n(other.awaits.begin(), first.moving.count, false);
  const Reaction reaction(second, secondResult);
  forEachShared(first, second, [&](std::size_t i, std::size_t k) {
    const ObjectState& own = first.objects[first.moving[i].body];
    const ObjectState& its = second.objects[second.moving[k].body];
    other.push[i] = reaction.on(second.moving[k].body);
    other.awaits[i] = its.beingMoved || its.poseRevision != own.poseRevision;
  });
}

void followMovedBodies(const HapticState& first, HapticState& second, const ForceResult& secondResult) noexcept {
  const Reaction reaction(second, secondResult);
  for (std::size_t k = 0; k < second.moving.count; ++k) second.moving[k].moved = false;
  forEachShared(first, second, [&](std::size_t i, std::size_t k) {
    const MovingBody& leads = first.moving[i];
    MovingBody& follows = second.moving[k];
    const bool isEdited = first.objects[leads.body].poseRevision != second.objects[follows.body].poseRevision ||
                          first.objects[leads.body].beingMoved || second.objects[follows.body].beingMoved;
    if (isEdited || &first.rigidBody(leads) != &second.rigidBody(follows)) return;
    follows.state = leads.state;
    follows.moved = !(poseOf(second.rigidBody(follows), follows.state) == second.bodies[follows.body].current);
    endMotion(second, follows, follows.moved ? reaction.felt(follows.body) : Push{});
  });
}

bool updateMotionState(const HapticState& state, std::uint64_t tick, MotionState& motion) noexcept {
  const std::size_t before = motion.bodyCount;
  bool changed = false;
  motion.bodyCount = 0;
  const auto add = [&](std::size_t body, BodyCondition condition) {
    const BodyState now{state.objects[body].id, state.bodies[body].current, condition};
    changed = changed || !(now == motion.body[motion.bodyCount]);
    motion.body[motion.bodyCount++] = now;
  };
  std::size_t next = 0;  // of those that are driven or held, in order of index
  const auto addOthersUpTo = [&](std::size_t body) {
    for (; next < body && motion.bodyCount < motion.body.size(); ++next) {
      const bool isHeld = state.features.tool && state.tool.body == next;
      const bool isTool = state.features.tool && state.scene->objects[next].tool != nullptr;
      if (!isTool && !state.isDriven(next)) continue;
      add(next, state.bodies[next].moving || isHeld ? BodyCondition::kAwake : BodyCondition::kAsleep);
    }
  };
  const bool anyOthers = state.driven.count > 0 || state.features.tool;
  for (std::size_t i = 0; i < state.moving.count; ++i) {
    const MovingBody& moving = state.moving[i];
    if (anyOthers) addOthersUpTo(moving.body);
    if (motion.bodyCount < motion.body.size()) add(moving.body, moving.state.condition);
  }
  if (anyOthers) addOthersUpTo(state.objects.count);
  changed = updateToolState(state, motion.tool) || changed;
  changed = changed || before != motion.bodyCount;
  if (changed) motion.tick = tick;
  return changed;
}

}  // namespace haptics

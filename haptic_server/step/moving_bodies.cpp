#include "haptic_server/step/moving_bodies.h"

#include <algorithm>

#include "haptic_server/collision/moving_together.h"
#include "haptic_server/motion/rigid_motion.h"
#include "haptic_server/step/held_springs.h"
#include "haptic_server/step/tool_step.h"

namespace haptics {
namespace {

/// The part of the tick's allowance that the bodies' motions may take in any case; beyond it they move in turn.
[[nodiscard]] std::int64_t motionUnits(const HapticState& state) noexcept { return state.allowance.left() / 2; }

/// What one body is given of a force (N, world) on the hand.
class Reaction {
 public:
  Reaction(const HapticState& state, const ContactResult& contact, Vec3 force_N) noexcept
      : state_(state), contact_(contact), force_N_(contact.touching ? force_N : Vec3(0)) {}

  [[nodiscard]] Push on(std::size_t body) const noexcept {
    if (!contact_.touching) return {};
    return state_.features.tool ? pushOfTool(state_, body) : Push{ofPoint(body), contact_.ihip};
  }

 private:
  const HapticState& state_;
  const ContactResult& contact_;
  Vec3 force_N_;

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

/// Attributes the work that a moving surface does on the hand with the force that is held meanwhile.
void nameWork(HapticState& state, const MovingBody& moving, const Push& push, double part) noexcept {
  const Pose& now = state.bodies[moving.body].current;
  const Vec3 way = toWorld(poseOf(*moving.what, moving.state), toLocal(now, push.place_m)) - push.place_m;
  state.energy.attribute(state.objects[moving.body].id, EnergyFeature::kMotion, -part * glm::dot(push.force_N, way));
}

/// Bodies that meet one another, all in one tick.
void moveCollidingBodies(HapticState& state, const StepConfig& config, const Reaction& reaction, double part,
                         const MotionAllowance& motion) noexcept {
  std::array<Collider, kMaxColliders> colliders;
  const std::size_t count = state.motion.collidingCount;
  for (std::size_t i = 0; i < count; ++i) {
    CollidingBody& is = state.colliding[i];
    const Body& body = state.bodies[is.body];
    MovingBody* moving = is.moving < 0 ? nullptr : &state.moving[static_cast<std::size_t>(is.moving)];
    colliders[i] = {body.surface, is.points, body.current, nullptr, nullptr, {}, body.pendingRemoval, is.isPut};
    is.isPut = false;
    if (moving == nullptr || state.objects[is.body].beingMoved) continue;
    colliders[i].what = moving->what;
    colliders[i].state = &moving->state;
    colliders[i].pose = poseOf(*moving->what, moving->state);
    colliders[i].push = reaction.on(is.body);
  }
  CollisionAllowance allowance{Allowance(state.allowance.left() / 2), motion};
  if (!moveTogether({colliders.data(), count}, state.pairs, config.period_s, allowance)) ++state.report.allowanceSpent;
  for (std::size_t i = 0; i < count; ++i) {
    if (colliders[i].state == nullptr) continue;
    MovingBody& moving = state.moving[static_cast<std::size_t>(state.colliding[i].moving)];
    moving.moved = !(poseOf(*moving.what, moving.state) == colliders[i].pose);
    if (colliders[i].push.any()) nameWork(state, moving, colliders[i].push, part);
    if (isStopped(moving.state.condition)) state.bodies[moving.body].pendingRemoval = true;
  }
}

}  // namespace

void takeMovedPoses(HapticState& state) noexcept {
  for (std::size_t i = 0; i < state.motion.count; ++i) {
    const MovingBody& moving = state.moving[i];
    if (state.objects[moving.body].beingMoved) continue;
    Body& body = state.bodies[moving.body];
    if (!moving.moved && !body.moving) continue;
    body.previous = lastTestedPose(state, body);
    if (moving.moved) body.current = poseOf(*moving.what, moving.state);
    body.update();
  }
}

std::int64_t unitsOfMotion(const HapticState& state) noexcept {
  std::int64_t units = 0;
  for (std::size_t i = 0; i < state.motion.count; ++i) {
    const MovingBody& moving = state.moving[i];
    if (moving.state.condition == BodyCondition::kAwake) units += leastMotionUnits(*moving.what, moving.state);
  }
  if (state.motion.collidingCount > 0) units += leastCollisionUnits(state.pairs);
  return std::min(units, motionUnits(state));
}

void moveBodies(HapticState& state, const StepConfig& config, const ForceResult& result) noexcept {
  const ContactResult& contact = result.contact;
  const ForceComponents& force = result.force;
  const Reaction reaction(state, contact, force.contact);
  const std::int64_t left = result.keptForMotion + std::max<std::int64_t>(0, contact.work.allowance.left());
  MotionAllowance allowance{Allowance(std::min(motionUnits(state), left)), Allowance(state.allowance.left() / 8)};
  const double part = writtenFraction(force.written, force.contact);
  if (state.motion.collidingCount > 0) moveCollidingBodies(state, config, reaction, part, allowance);
  std::size_t next = 0;
  bool inTurn = false;
  for (std::size_t k = 0; k < state.motion.count; ++k) {
    const std::size_t i = (state.motion.next + k) % state.motion.count;
    MovingBody& moving = state.moving[i];
    if (moving.collides) continue;
    moving.moved = false;
    if (state.objects[moving.body].beingMoved) continue;
    const Push push = reaction.on(moving.body);
    if (moving.state.condition != BodyCondition::kAwake && !push.any()) continue;
    if (k > 0 && !push.any() && allowance.least.left() < leastMotionUnits(*moving.what, moving.state)) {
      if (!inTurn) next = i;
      inTurn = true;
      ++moving.waited;
      continue;
    }
    moveRigidBody(*moving.what, moving.state, push, config.period_s * (1 + moving.waited), allowance);
    moving.waited = 0;
    moving.moved = true;
    if (push.any()) nameWork(state, moving, push, part);
    if (isStopped(moving.state.condition)) state.bodies[moving.body].pendingRemoval = true;
  }
  state.motion.next = next;
}

bool describeMotion(const HapticState& state, std::uint64_t tick, MotionState& motion) noexcept {
  const std::size_t before = motion.bodyCount;
  bool changed = false;
  motion.bodyCount = 0;
  const auto add = [&](std::size_t body, BodyCondition condition) {
    const BodyState now{state.objects[body].id, state.bodies[body].current, condition};
    changed = changed || !(now == motion.body[motion.bodyCount]);
    motion.body[motion.bodyCount++] = now;
  };
  bool isToolDue = state.features.tool;
  for (std::size_t i = 0; i < state.motion.count; ++i) {
    const MovingBody& moving = state.moving[i];
    if (isToolDue && state.tool.body < moving.body) add(state.tool.body, BodyCondition::kAwake);
    isToolDue = isToolDue && state.tool.body > moving.body;
    add(moving.body, moving.state.condition);
  }
  if (isToolDue) add(state.tool.body, BodyCondition::kAwake);
  changed = describeTool(state, motion.tool) || changed;
  changed = changed || before != motion.bodyCount;
  if (changed) motion.tick = tick;
  return changed;
}

}  // namespace haptics

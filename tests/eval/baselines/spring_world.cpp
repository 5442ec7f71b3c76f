#include "tests/eval/baselines/spring_world.h"

#include <algorithm>
#include <cmath>

#include "haptic_server/engine/contact/frame.h"
#include "haptic_server/engine/motion/rigid_motion.h"
#include "tests/eval/moving_world.h"

namespace haptics::eval {
namespace {

constexpr double kShare = 16;
const double kSpeed = std::sqrt(8.0) - 2;  // w

void pushAt(Collider& body, Vec3 place, Vec3 force_N) {
  if (body.state == nullptr) return;
  body.push.force_N += force_N;
  body.push.torque_Nm += glm::cross(place - body.state->centre_m, force_N);
}

[[nodiscard]] Vec3 velocityAt(const Collider& body, Vec3 place) {
  if (body.state == nullptr) return Vec3(0);
  const RigidVelocity v = velocityOf(*body.rigidBody, *body.state);
  return v.linear + glm::cross(v.angular, place - body.state->centre_m);
}

[[nodiscard]] double reducedMass_kg(const Collider& a, const Collider& b) {
  const auto perMass = [](const Collider& body) {
    return body.rigidBody == nullptr ? 0 : 1 / body.rigidBody->mass.mass_kg;
  };
  return 1 / (perMass(a) + perMass(b));
}

}  // namespace

double springStiffness_N_per_m(double mass_kg) { return kSpeed * kSpeed / kShare * mass_kg / (kPeriod_s * kPeriod_s); }
double springDamping_Ns_per_m(double mass_kg) { return 2 * kSpeed / kShare * mass_kg / kPeriod_s; }

std::uint64_t SpringWorld::add(const MovingSolid& solid, const Pose& pose, bool moves) {
  ServoObject object{objects_.size() + 1, solid.surface, pose, kSpring_N_per_m, 0};
  if (moves) object.motion = std::make_shared<RigidBody>(solid.body);
  objects_.push_back(std::move(object));
  return objects_.size();
}

void SpringWorld::publish() {
  bodies_.assign(objects_.size(), {});
  states_.assign(objects_.size(), {});
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const ServoObject& object = objects_[i];
    bodies_[i].surface = object.surface.get();
    bodies_[i].points = object.collision.get();
    bodies_[i].pose = object.pose;
    if (object.motion == nullptr) continue;
    states_[i] = restingAt(*object.motion, object.pose);
    bodies_[i].rigidBody = object.motion.get();
    bodies_[i].state = &states_[i];
  }
}

TelemetrySample SpringWorld::tick(Vec3 hip) {
  for (Collider& body : bodies_) body.push = {};
  TelemetrySample sample;
  sample.force.contact = pushByHand(hip);
  if (std::ranges::any_of(bodies_, isAwake)) {
    Allowance endless;
    static_cast<void>(findBodyContacts(bodies_, pairs_, kPeriod_s, endless));
    for (const BodyPair& pair : pairs_.all()) {
      if (pair.used != 0) pushApart(pair);
    }
    move();
  }
  return sample;
}

/// Returns the force on the hand.
Vec3 SpringWorld::pushByHand(Vec3 hip) {
  Vec3 force_N(0);
  for (Collider& body : bodies_) {
    const Vec3 at = toLocal(body.pose, hip);
    if (glm::distance(at, body.surface->centre()) > body.surface->radius_m()) continue;
    int looked = 0;
    const ClosestPoint foot = body.surface->closestFoot(at, 1 << 20, looked);
    if (body.surface->isOutside(foot, at)) continue;
    const Vec3 out_N = kSpring_N_per_m * (toWorld(body.pose, foot.point) - hip);
    force_N += out_N;
    pushAt(body, hip, -out_N);
  }
  if (force_N != Vec3(0)) wake();
  return force_N;
}

void SpringWorld::pushApart(const BodyPair& pair) {
  Collider &first = bodies_[pair.first], &second = bodies_[pair.second];
  const double mass_kg = reducedMass_kg(first, second);
  const double damping = springDamping_Ns_per_m(mass_kg);
  const double friction = std::sqrt(first.points->friction * second.points->friction);
  for (const BodyContact& contact : pair.contacts.all()) {
    Collider &on = contact.second != 0 ? second : first, &under = contact.second != 0 ? first : second;
    const Vec3 place = toWorld(on.pose, contact.place);
    const Vec3 normal = under.pose.rotation * contact.normal;
    const double depth_m = glm::dot(normal, toWorld(under.pose, contact.foot) - place);
    if (depth_m <= 0) continue;
    const Vec3 velocity = velocityAt(on, place) - velocityAt(under, place);
    const double opening = glm::dot(velocity, normal);
    const double pressing_N = std::max(springStiffness_N_per_m(mass_kg) * depth_m - damping * opening, 0.0);
    const Vec3 sliding = velocity - opening * normal;
    const double speed = glm::length(sliding);
    const double rubbing = speed > 0 ? std::min(friction * pressing_N / speed, damping) : 0;
    const Vec3 force_N = pressing_N * normal - rubbing * sliding;
    pushAt(on, place, force_N);
    pushAt(under, place, -force_N);
  }
}

void SpringWorld::wake() {
  for (RigidState& state : states_) {
    state.still_s = 0;
    if (state.condition == BodyCondition::kAsleep) state.condition = BodyCondition::kAwake;
  }
}

void SpringWorld::move() {
  bool still = true;
  for (Collider& body : bodies_) {
    if (!isAwake(body)) continue;
    body.push.place_m = body.state->centre_m;
    const RigidPlace before = placeOf(*body.state);
    driveRigidBody(*body.rigidBody, *body.state, body.push, kPeriod_s);
    advanceRigidBody(*body.rigidBody, *body.state, kPeriod_s);
    still = keepInWorld(*body.rigidBody, *body.state, before) && isStill(*body.rigidBody, *body.state, {}, kPeriod_s) &&
            still;
    body.pose = haptics::poseOf(*body.rigidBody, *body.state);
  }
  if (!still) return;
  for (RigidState& state : states_) stop(state, BodyCondition::kAsleep);
}

double SpringWorld::energyOf(std::uint64_t id) const {
  const Collider& body = bodies_[id - 1];
  return body.rigidBody == nullptr ? 0 : haptics::energyOf(*body.rigidBody, *body.state);
}

}  // namespace haptics::eval

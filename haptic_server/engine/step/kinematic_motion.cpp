#include "haptic_server/engine/step/kinematic_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/maths/rotation.h"
#include "haptic_server/engine/contact/surface_shift.h"

namespace haptics {
namespace {

/// No point of the surface goes farther.
[[nodiscard]] double longestWay_m(const CollisionMesh& surface, const Pose& from, const Pose& to) noexcept {
  const double angle_rad = glm::length(rotationVector(to.rotation * glm::conjugate(from.rotation)));
  return glm::distance(toWorld(from, surface.centre()), toWorld(to, surface.centre())) + angle_rad * surface.radius_m();
}

/// A sample that comes now does not begin a stream.
template <class Motion>
[[nodiscard]] bool goesOn(const Motion& motion, double period_s) noexcept {
  return motion.number != 0 && static_cast<double>(motion.since) < kLongestPause_s / period_s;
}

/// Begins the way to another sample, of which a point goes way_m at most.
template <class Sample, class Motion>
void setOut(const Sample& sample, double way_m, double period_s, Motion& motion) noexcept {
  if (goesOn(motion, period_s)) {
    const auto since = static_cast<double>(motion.since);
    const double beginning = sample.first_s / period_s - kCaughtUp * static_cast<double>(motion.begun);
    motion.left = std::clamp(beginning, since, 2 * since);
  } else {
    const double time_s = std::clamp(way_m / kFirstSpeed_m_per_s, sample.first_s, kLongestPause_s);
    motion.left = std::max(std::round(time_s / period_s), 1.0);
    motion.begun = 0;
  }
  motion.since = 0;
  motion.number = sample.number;
}

/// @return The part of the way to the newest sample that it goes in this tick.
template <class Motion>
[[nodiscard]] double nextPart(Motion& motion) noexcept {
  return 1 / std::max(std::exchange(motion.left, std::max(motion.left - 1, 0.0)), 1.0);
}

/// @return Whether its stream may go on.
template <class Motion>
[[nodiscard]] bool countTick(Motion& motion, double period_s) noexcept {
  if (!goesOn(motion, period_s)) return false;
  ++motion.since;
  ++motion.begun;
  return true;
}

/// The contact goes with the surface of a body whose vertices were where `before` has them.
void carryContact(HapticState& state, std::size_t object, const CollisionMesh& before, double farthest_m) noexcept {
  constexpr int kShare = 8;  // of the tick's allowance
  Body& body = state.bodies[object];
  ContactState& contact = state.contact;
  contact.clear = {};
  state.contactCache = {};
  const ContactSurface& held = contact.holding[0];
  const bool isHeld = contact.mode == ContactState::Mode::kOneSurface && held.body == static_cast<int>(object);
  if (isHeld) {
    const Vec3 to = movedWith(before.triangle(held.triangle), body.surface->triangle(held.triangle), contact.local);
    body.shift = to - contact.local;
    contact.local = to;
  } else {
    Allowance allowance(state.allowance.left() / kShare);
    body.shift = surfaceShift(before, *body.surface, toLocal(body.previous, contact.ihip), farthest_m, allowance);
    if (allowance.isSpent()) contact.containmentUnchecked = contact.unfinished = true;
  }
  body.deforming = isHeld || body.shift != Vec3(0);
}

/// What sticks to the surface goes with it.
void carryFriction(HapticState& state, std::size_t object) noexcept {
  const Body& body = state.bodies[object];
  for (HeldFriction& friction : state.surface.friction) {
    if (friction.object == state.objects[object].id) friction.law.carry(friction.law.stickingPoint() + body.shift);
  }
}

}  // namespace

bool moveDrivenObject(const ServoScene& scene, HapticState& state, double period_s, std::size_t object) noexcept {
  const KinematicPose& sample = scene.kinematic[object];
  KinematicMotion& motion = state.driven[object];
  if (sample.number == 0) {
    motion = {};
    return false;
  }
  const Body& body = state.bodies[object];
  if (motion.number != sample.number) {
    setOut(sample, longestWay_m(*body.surface, body.current, sample.pose), period_s, motion);
    state.objects[object].beingMoved = false;
  }
  if (motion.left > 0) {
    const Pose previous = lastTestedPose(state, body);
    const double part = nextPart(motion);
    state.place(object, previous, part == 1 ? sample.pose : interpolate(body.current, sample.pose, part));
  } else if (body.moving) {
    state.place(object, lastTestedPose(state, body), body.current);
  }
  return countTick(motion, period_s) || motion.left > 0 || body.moving;
}

bool moveDrivenShape(const ServoScene& scene, HapticState& state, double period_s, std::size_t object) noexcept {
  const KinematicShape& sample = scene.shapes[object];
  ShapeMotion& motion = state.reshaped[object];
  if (sample.number == 0) return false;
  Body& body = state.bodies[object];
  if (motion.number != sample.number) {
    const bool begins = motion.number == 0;
    const std::uint64_t last = begins ? std::max<std::uint64_t>(sample.first, 1) - 1 : motion.number;
    const double along = begins ? ShapeSamples::kNewest : motion.along;
    motion.along = std::max(along - static_cast<double>(sample.number - last), sample.samples.oldest());
    setOut(sample, sample.way_m, period_s, motion);
  }
  const bool wasDeforming = body.deforming;
  body.deforming = false;
  body.shift = Vec3(0);
  if (motion.left > 0) {
    const double part = nextPart(motion);
    motion.along = part == 1 ? ShapeSamples::kNewest : motion.along + part * (ShapeSamples::kNewest - motion.along);
    const CollisionMesh& before = *body.surface;
    const auto [surface, farthest_m] = memoryOf(sample, state).moveTo(sample.samples, motion.along, &before);
    body.surface = surface;
    carryContact(state, object, before, farthest_m);
    if (state.features.detail) carryFriction(state, object);
  }
  body.update();
  return countTick(motion, period_s) || motion.left > 0 || body.deforming || wasDeforming;
}

void beginDriving(HapticState& state) noexcept {
  if (state.driven.count == 0) std::fill_n(state.driven.items.begin(), state.objects.count, KinematicMotion{});
  state.driven.count = state.objects.count;
  state.features.beingMoved = true;
}

void beginReshaping(HapticState& state) noexcept {
  if (state.reshaped.count == 0) std::fill_n(state.reshaped.items.begin(), state.objects.count, ShapeMotion{});
  state.reshaped.count = state.objects.count;
  state.features.beingMoved = true;
}

void moveDrivenObjects(const ServoScene& scene, HapticState& state, double period_s) noexcept {
  for (std::size_t i = 0; i < state.driven.count; ++i) static_cast<void>(moveDrivenObject(scene, state, period_s, i));
  for (std::size_t i = 0; i < state.reshaped.count; ++i) static_cast<void>(moveDrivenShape(scene, state, period_s, i));
}

bool updateShapePlaces(const ServoScene& scene, const HapticState& state, ShapePlaces& shapes) noexcept {
  const std::size_t before = std::exchange(shapes.count, 0);
  bool changed = false;
  for (std::size_t i = 0; i < state.reshaped.count; ++i) {
    const ShapeMotion& motion = state.reshaped[i];
    if (motion.number == 0) continue;
    const double behind = ShapeSamples::kNewest - motion.along;
    const ShapePlace now{scene.objects[i].id, static_cast<double>(motion.number) - behind};
    changed = changed || !(now == shapes.place[shapes.count]);
    shapes.place[shapes.count++] = now;
  }
  return changed || before != shapes.count;
}

}  // namespace haptics

#pragma once

// The tick as a template over AllCorrections or a policy derived from it. Production includes this once, in contact.cpp.

#include <algorithm>
#include <cmath>

#include "haptic_server/contact/constraint_solver_impl.h"
#include "haptic_server/contact/contact_tick.h"
#include "haptic_server/contact/held_surfaces_impl.h"
#include "haptic_server/contact/nearest_foot.h"
#include "haptic_server/contact/neighborhood_watch_impl.h"
#include "haptic_server/contact/several_surfaces_impl.h"
#include "haptic_server/contact/surface_following_impl.h"
#include "haptic_server/contact/way_out.h"
#include "haptic_server/geometry/enclosure.h"

namespace haptics {

/// followContact() under another policy, always by the long way.
template <class Corrections>
[[nodiscard]] ContactResult followContact(std::span<const Body> bodies, ContactState& state, Vec3 hip,
                                          const Allowance& allowance = {}) noexcept {
  return ContactTick<Corrections>(bodies, state, usableHip(state, hip), allowance).run();
}

template <class Corrections>

ContactTick<Corrections>::ContactTick(std::span<const Body> bodies, ContactState& state, Vec3 hip,
                                      const Allowance& allowance) noexcept
    : bodies_(bodies),
      state_(state),
      stride_(state.stride),
      hip_(state.stride < 1 ? glm::mix(state.hip, hip, state.stride) : hip) {
  work_.allowance = allowance;
}

template <class Corrections>
ContactResult ContactTick<Corrections>::run() noexcept {
  // What is kept of the allowance for finding out whether the IHIP is inside of a body, and for putting it out.
  const std::int64_t aside = work_.allowance.left() / 4;
  work_.allowance.spend(aside);
  start();
  makeSteps();
  work_.allowance.spend(-aside);
  if (work_.behind) {
    state_.unchecked = state_.unchecked || mayBeInside();
    return result();
  }
  if (state_.unchecked || mayBeInside()) {
    work_.insideOf = enclosingBody();
    if (work_.insideOf >= 0) putOut();
    state_.unchecked = work_.allowance.isSpent();
  }
  state_.reseated = false;
  return result();
}

template <class Corrections>
struct ContactTick<Corrections>::Checkpoint {
  Mode mode;
  int holdingCount;
  std::array<HoldingSurface, ContactState::kMaxHolding> holding;
  Feature feature;
  Vec3 local;
  Vec3 ihip;
  Foot foot;
  bool settled;
};

template <class Corrections>
typename ContactTick<Corrections>::Checkpoint ContactTick<Corrections>::checkpoint() const noexcept {
  return {state_.mode, state_.holdingCount, state_.holding, state_.feature, state_.local, state_.ihip, foot_, settled_};
}

template <class Corrections>
void ContactTick<Corrections>::restore(const Checkpoint& before) noexcept {
  state_.mode = before.mode;
  state_.holdingCount = before.holdingCount;
  state_.holding = before.holding;
  state_.feature = before.feature;
  state_.local = before.local;
  state_.ihip = before.ihip;
  foot_ = before.foot;
  settled_ = before.settled;
}

/// To the end of the HIP's way, or as far as the allowance lasts: in what a step did after that no answer can be trusted,
/// so that it counts as not made. A tick that makes none tries an eighth of its way in the next, where segments are shorter
/// and meet less.
template <class Corrections>
void ContactTick<Corrections>::makeSteps() noexcept {
  constexpr double kShorter = 0x1p-3;
  constexpr double kLeastStride = 0x1p-30;
  double now = 0;
  // Contacts and releases within a step may divide it again; a bound on all of them together bounds the tick.
  while (now < 1 && work_.steps < 2 * kMaxSteps) {
    const bool last = ++work_.steps >= kMaxSteps || work_.interrupted;
    const Checkpoint before = checkpoint();
    const double end = advance(now, last, before);
    if (work_.allowance.isSpent()) {
      restore(before);
      if (now == 0) state_.stride = std::max(kLeastStride, state_.stride * kShorter);
      work_.behind = true;
      break;
    }
    now = end;
  }
  if (!work_.behind) {
    state_.stride = std::min(1.0, 2 * state_.stride);
    now = 1;
  }
  state_.reached = now * stride_;
  work_.behind = state_.reached < 1;
  state_.hip = hipAt(now);
  if (work_.behind) setTime(now);
}

template <class Corrections>
void ContactTick<Corrections>::start() noexcept {
  near_.gather(bodies_, state_, hip_, work_);
  constexpr double kUsualExtent_m = 0.1;
  const double extent_m = Corrections::kScaleFreeTolerances ? near_.extent_m() : kUsualExtent_m;
  skin_ = kSkin * extent_m;
  pathLift_ = kPathLift * extent_m;
  lift_ = kLift * extent_m;
  if (!Corrections::kObjectFrameSegments) near_.setTime(bodies_, 1);
  const bool oneSurface = state_.mode == Mode::kOneSurface;
  if (oneSurface) {
    const Body& body = bodies_[static_cast<std::size_t>(held().body)];
    foot_ = heldFoot(*body.surface, state_, motionOver(body).from);
  }
  if (oneSurface && near_.count() == 1) return;  // no other body's frame to keep
  const Vec3 ihip = oneSurface ? heldNear().frame.toWorld(lifted(state_.local, held(), pathLift_)) : state_.ihip;
  const Points from = near_.inEachFrame(ihip);
  near_.moveAll(from, 1);
}

/// The time to advance to where the HIP is followed by length: while several surfaces hold.
template <class Corrections>
double ContactTick<Corrections>::shortStepEnd(double now) const noexcept {
  if (!Corrections::kSubsteps || state_.holdingCount == 0) return 1;
  const Body& body = bodies_[static_cast<std::size_t>(held().body)];
  const double twiceArea2 = squaredLength(body.surface->triangle(held().triangle).areaNormal());
  const double step2 = body.moving ? squaredLength(toLocal(body.current, hip_) - toLocal(body.previous, state_.hip))
                                   : squaredLength(hip_ - state_.hip);
  if (inOneStep(step2, twiceArea2)) return 1;
  const double part = kStepFraction * std::sqrt(std::sqrt(twiceArea2) / step2);
  return std::min(1.0, now + std::max(part, kLeastShortStep));
}

/// Returns the time reached; the end of the tick when this is its last step, unless something is touched on the way.
template <class Corrections>
double ContactTick<Corrections>::advance(double now, bool last, const Checkpoint& before) noexcept {
  if (state_.mode == Mode::kOneSurface) return advanceOnSurface(now, last);
  const double end = state_.mode == Mode::kFree || last ? 1 : shortStepEnd(now);
  setTime(end);
  if (state_.mode == Mode::kFree) return advanceFree(now, end, hipAt(end));
  return advanceOnSeveral(now, end, before);
}

/// Paper 3.2, first contact: the segment between two places of the HIP against the bounding hierarchies. Deviations:
/// the segment is taken in each body's own frame, from where the HIP was in it to where it is, so that a body cannot
/// pass through a still HIP; all bodies advance to the instant of the earliest hit, and the search runs in the same
/// tick.
template <class Corrections>
double ContactTick<Corrections>::advanceFree(double now, double end, Vec3 hip) noexcept {
  const Points to = near_.inEachFrame(hip);
  // Starts a hair behind on the way into closed bodies: a crossing lost to rounding where two ticks meet is seen now,
  // and the start only moves farther above all that can be entered. A sheet could be entered from its other side
  // instead; there the rule for points on the plane (Segment::enters) joins the segments.
  for (int i = 0; i < near_.count(); ++i) {
    const Vec3 way = to[static_cast<std::size_t>(i)] - near_[i].from;
    const double length = glm::length(way);
    if (length > 0 && near_[i].surface->closed()) near_[i].from -= way * (lift_ / length);
  }
  const Hit hit = firstNewContact(to, [](int, std::uint32_t) noexcept { return false; });
  if (!hit) {
    near_.moveAll(to, 1);
    setFree(hip);
    return end;
  }
  touch(hit, to);
  if (!Corrections::kSameTickSearch) {
    recordedOnly_ = true;
    return 1;
  }
  const double reached = now + (end - now) * hit.crossing.time;
  if (reached < 1) return reached;
  setTime(1);
  state_.mode == Mode::kOneSurface ? followSurface(hip_) : solve(hip_);
  return 1;
}

/// To where the path enters; before a triangle that others pass through, a little less far: the solver starts from
/// there, off all of them.
template <class Corrections>
void ContactTick<Corrections>::touch(const Hit& hit, const Points& to) noexcept {
  const Near& near = near_[hit.near];
  const HoldingSurface touched{near.body, hit.crossing.side, hit.crossing.triangle};
  if (isCrossed(touched)) {
    const double back = 2 * skin_ / glm::distance(near.from, to[static_cast<std::size_t>(hit.near)]);
    near_.moveAll(to, std::max(hit.crossing.time / 2, hit.crossing.time - back));
    state_.mode = Mode::kSeveralSurfaces;
    state_.holdingCount = 1;
    state_.holding[0] = touched;
    state_.ihip = near.frame.toWorld(near.from);
    return;
  }
  near_.moveAll(to, hit.crossing.time);
  Foot foot;
  foot.triangle = hit.crossing.triangle;
  foot.point = near.from;
  hold(touched, foot, near.frame.toWorld(near.from));
}

/// The path of the IHIP keeps it outside of bodies at rest. Moving ones can close in on it until the solver finds no way
/// out of theirs, a mesh that passes through itself has surface inside of itself, and an adoption puts bodies anywhere.
template <class Corrections>
bool ContactTick<Corrections>::mayBeInside() const noexcept {
  if (!Corrections::kContainment || !Corrections::kObjectFrameSegments) return false;
  if (state_.reseated || work_.unsettled || work_.crowdedOut > 0) return true;
  const bool alone = state_.mode == Mode::kOneSurface && near_.count() == 1;  // its own surface holds it
  for (int i = 0; i < near_.count(); ++i) {
    const Body& body = bodies_[static_cast<std::size_t>(near_[i].body)];
    if ((body.moving && !alone) || body.surface->anyCrossed()) return true;
  }
  return false;
}

/// The closed body that the IHIP is inside of at the end of the tick, or the sheet that it is behind; -1 when there is none,
/// or when the allowance is spent.
template <class Corrections>
int ContactTick<Corrections>::enclosingBody() noexcept {
  near_.setTime(bodies_, 1);
  work_.allowance.spend(Allowance::kSphere * static_cast<std::int64_t>(bodies_.size()));
  const int onSurface = state_.mode == Mode::kOneSurface ? held().body : -1;
  for (int b = 0; b < static_cast<int>(bodies_.size()) && !work_.allowance.isSpent(); ++b) {
    const Body& body = bodies_[static_cast<std::size_t>(b)];
    if (body.leaving || !body.surface->closed() || !withinSphere(body, state_.ihip)) continue;
    Vec3 at = body.frame.toLocal(state_.ihip);
    if (b == onSurface) {
      if (!body.surface->anyCrossed()) continue;
      at = state_.local + body.surface->normal(foot_) * lift_;
    }
    ++work_.segments;
    if (windingNumber(*body.surface, at, work_.allowance) <= 0) continue;
    const Foot foot = nearestFoot(*body.surface, at, work_.allowance);
    if (work_.allowance.isSpent()) return -1;
    if (foot.squaredDistance > kDeep * kDeep * skin_ * skin_) return b;
  }
  for (int i = 0; i < near_.count() && !work_.allowance.isSpent(); ++i) {
    const Near& near = near_[i];
    if (near.surface->closed() || near.leaving || near.body == onSurface) continue;
    const Vec3 to = near.frame.toLocal(state_.ihip);
    if (near.from == to) continue;
    ++work_.segments;
    if (near.surface->firstCrossing<SegmentTest>(near.from, to, work_.allowance)) return near.body;
  }
  return -1;
}

/// Bodies that pass through each other can close a pocket on the IHIP. It is put where it is outside of all of them, and
/// the path of the HIP taken from there.
template <class Corrections>
void ContactTick<Corrections>::putOut() noexcept {
  const Vec3 way = state_.ihip - hip_;
  const double depth = glm::length(way);
  const auto out = wayOut(bodies_, near_, state_.ihip, depth > 0 ? way / depth : Vec3(0), skin_, work_);
  if (!out) return;
  work_.putOut = true;
  setFree(*out);
  near_.gather(bodies_, state_, hip_, work_);  // what is near there
  near_.setTime(bodies_, 1);
  near_.moveAll(near_.inEachFrame(*out), 1);
  (void)advanceFree(1, 1, hip_);
  if (work_.allowance.isSpent()) return setFree(*out);  // what is near there is not known
  if (state_.mode == Mode::kFree || (enclosingBody() < 0 && !work_.allowance.isSpent())) return;
  state_.mode = Mode::kSeveralSurfaces;  // where it is outside, to be settled by the next tick
  state_.holdingCount = 0;
  state_.ihip = *out;
}

template <class Corrections>
void ContactTick<Corrections>::setFree(Vec3 hip) noexcept {
  state_.mode = Mode::kFree;
  state_.holdingCount = 0;
  state_.ihip = hip;
}

template <class Corrections>
void ContactTick<Corrections>::hold(const HoldingSurface& surface, const Foot& foot, Vec3 ihip) noexcept {
  state_.mode = Mode::kOneSurface;
  state_.holdingCount = 1;
  state_.holding[0] = surface;
  state_.feature = foot.feature;
  state_.local = foot.point;
  state_.ihip = ihip;
  foot_ = foot;
  settled_ = false;
}

template <class Corrections>
ContactResult ContactTick<Corrections>::result() noexcept {
  ContactResult result;
  result.ihip = state_.ihip;
  result.work = work_;
  if (state_.mode == Mode::kFree) return result;
  if (!Corrections::kSameTickSearch && recordedOnly_) {
    result.ihip = hip_;
    return result;
  }
  const Near& near = heldNear();
  const Vec3 way = state_.ihip - hip_;
  result.touching = true;
  result.body = held().body;
  if (state_.mode == Mode::kOneSurface) {
    result.alongNormal = settled_ && foot_.feature == Feature::kPolygon;
    result.penetration_m = result.alongNormal
                               ? distanceFrom(near.surface->triangle(foot_.triangle), near.frame.toLocal(hip_))
                               : glm::length(way);
    result.normal = near.frame.turn(near.surface->normal(foot_) * static_cast<double>(held().side));
  } else {
    const std::uint32_t t = held().triangle;
    result.penetration_m = glm::length(way);
    foot_ = closestOn(near.surface->triangle(t), t, near.frame.toLocal(state_.ihip));
    result.normal = result.penetration_m > 0
                        ? way / result.penetration_m
                        : near.frame.turn(near.surface->faceNormal(t) * static_cast<double>(held().side));
  }
  result.primitive = primitiveOf(*near.surface, foot_);
  return result;
}

}  // namespace haptics

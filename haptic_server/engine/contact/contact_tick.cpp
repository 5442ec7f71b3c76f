#include "haptic_server/engine/contact/contact_tick.h"

#include <algorithm>
#include <cmath>

#include "haptic_server/engine/contact/containment.h"
#include "haptic_server/engine/contact/free_motion.h"
#include "haptic_server/engine/contact/plane_solver.h"
#include "haptic_server/engine/contact/surface_walk.h"

namespace haptics {
namespace {

using Mode = ContactState::Mode;

/// Searches of one step that begin on a surface that was entered within it; the next step goes on.
constexpr int kMaxReentries = 4;

/// A tick: section 1.4 of README.md.
class ContactTick {
 public:
  explicit ContactTick(TickContext& tick) noexcept : tick_(tick) {}
  [[nodiscard]] ContactResult run() noexcept;

 private:
  void gather() noexcept;
  void beginStep(double now, WalkStep& step) noexcept;
  void moveFree(double now, WalkStep& step) noexcept;
  void walk(WalkStep& step, int searches) noexcept;
  [[nodiscard]] bool leave(WalkStep& step) noexcept;
  void moveOnSeveral(double now, WalkStep& step, const Checkpoint& before) noexcept;
  void solveAndWalk(WalkStep& step) noexcept;
  void endSteps(double now) noexcept;
  void carryWithBody() noexcept;
  [[nodiscard]] bool isOverrun() const noexcept;
  void letBodiesPass() noexcept;
  void leaveEnclosingBody() noexcept;
  [[nodiscard]] bool depenetrate() noexcept;
  [[nodiscard]] ContactResult result() noexcept;

  TickContext& tick_;
  bool recordedOnly_ = false;  // touched in this tick, to be searched in the next (sameTickSearch off)
};

/// What a step did after the allowance was spent cannot be trusted, so that it counts as not made.
ContactResult ContactTick::run() noexcept {
  const std::int64_t quarter = tick_.work.allowance.left() / 4;
  gather();  // 1 gather
  // A tick after one that did not come to its end has all for its path: some steps cost more than the rest, however short.
  const bool goesOn = tick_.stride < 1;
  const bool mayDepenetrate = tick_.state.containmentUnchecked || (!goesOn && mayBeInside(tick_));
  const std::int64_t depenetrationReserve = mayDepenetrate ? quarter : 0;
  tick_.work.allowance.spend(depenetrationReserve);
  double now = 0;
  while (now < 1) {  // after kMaxSteps steps for one contact more: what is held then goes to the end
    const Checkpoint before = tick_.checkpoint();
    WalkStep step;
    beginStep(now, step);  // 2 step
    switch (tick_.state.mode) {
      case Mode::kFree:
        moveFree(now, step);
        break;
      case Mode::kOneSurface:
        walk(step, 1 + kMaxReentries);  // 3 to 6
        break;
      case Mode::kSeveralSurfaces:
        moveOnSeveral(now, step, before);
        break;
    }
    if (tick_.work.allowance.isSpent()) {
      tick_.restore(before);
      tick_.work.allowanceSpent = true;
      break;
    }
    now = step.end;
  }
  endSteps(now);
  tick_.work.allowance.spend(-depenetrationReserve);
  leaveEnclosingBody();  // 7 enclosed?
  const ContactState& state = tick_.state;
  tick_.state.unfinished = state.reached < 1 || state.stride < 1 || state.containmentUnchecked;
  return result();
}

void ContactTick::walk(WalkStep& step, int searches) noexcept {
  for (bool touches = true; touches && searches > 0; --searches) {
    search(tick_, step);                                       // 3 search
    const bool clear = followPath(tick_, step);                // 4 guard
    if (!clear) takeOver(tick_, step.hip);                     // 5 blocked?
    touches = clear && isOutside(tick_, step) && leave(step);  // 6 outside?
  }
}

/// Returns whether a surface that is to be searched was entered on the way.
bool ContactTick::leave(WalkStep& step) noexcept {
  leaveSurface(tick_, step.found.foot, step.h, step.hip);
  if (tick_.state.mode == Mode::kSeveralSurfaces) solvePlanes(tick_, step.hip);
  if (tick_.state.mode != Mode::kOneSurface) return false;
  searchAnew(tick_, step);
  return true;
}

void ContactTick::gather() noexcept {
  tick_.near.gather(tick_.bodies, tick_.state, tick_.hip, tick_.work);
  constexpr double kUsualExtent_m = 0.1;
  const double extent_m = tick_.corrections.scaleFreeTolerances ? tick_.near.extent_m() : kUsualExtent_m;
  tick_.skin = kSkin * extent_m;
  tick_.pathOffset = kPathOffset * extent_m;
  tick_.startOffset = kStartOffset * extent_m;
  if (!tick_.corrections.objectFrameSegments) tick_.near.setTime(tick_.bodies, 1);
  Vec3 ihip = tick_.state.ihip;
  if (tick_.state.mode == Mode::kOneSurface) {
    tick_.foot = heldFoot(tick_.surface(tick_.held().body), tick_.state, hipMotion(tick_).from);
    if (tick_.near.count() == 1) return;  // no other body's frame to keep
    const Vec3 before = tick_.state.local - tick_.body(tick_.held().body).shift;
    ihip = tick_.nearOf(tick_.held()).frame.toWorld(tick_.lifted(before, tick_.held(), tick_.pathOffset));
  }
  tick_.near.moveAll(tick_.near.inEachFrame(ihip), 1);
  tick_.near.shiftWithSurfaces(tick_.bodies);
}

/// A free HIP goes to the end of the tick at once.
void ContactTick::beginStep(double now, WalkStep& step) noexcept {
  const bool last = ++tick_.work.steps >= kMaxSteps || tick_.work.interrupted;
  if (tick_.state.mode == Mode::kOneSurface) {
    if (!last && !tick_.settled && tick_.body(tick_.held().body).deforming) return settle(tick_, step);
    return stepOverRegions(tick_, now, last, step);
  }
  step.end = tick_.state.mode == Mode::kFree || last ? 1 : shortStepEnd(tick_, now);
  step.hip = tick_.hipAt(step.end);
  tick_.setTime(step.end);
}

void ContactTick::moveFree(double now, WalkStep& step) noexcept {
  step.end = advanceFree(tick_, now, step.end, step.hip);
  if (tick_.state.mode == Mode::kFree) return;
  if (!tick_.corrections.sameTickSearch) {
    recordedOnly_ = true;
    step.end = 1;
  } else if (step.end >= 1) {
    step.end = 1;
    step.hip = tick_.hip;
    tick_.setTime(1);
    if (tick_.state.mode == Mode::kSeveralSurfaces) return solveAndWalk(step);
    searchAnew(tick_, step);
    walk(step, kMaxReentries);
  }
}

void ContactTick::solveAndWalk(WalkStep& step) noexcept {
  solvePlanes(tick_, step.hip);
  if (tick_.state.mode != Mode::kOneSurface) return;
  searchAnew(tick_, step);
  walk(step, kMaxReentries);
}

/// Where the IHIP jumped, a minimum ended on the way, and where the slide from there leads depends on where the HIP was
/// then: the step is taken back, and goes only to that time. Where a surface let go, one of those that held may have
/// ended before.
void ContactTick::moveOnSeveral(double now, WalkStep& step, const Checkpoint& before) noexcept {
  const NearBodies::Points from = tick_.near.from();
  const bool interrupted = tick_.work.interrupted;
  const bool notConverged = tick_.work.notConverged;
  const bool divisible = tick_.corrections.substeps && before.holdingCount > 0 && tick_.work.steps < kMaxSteps / 2 &&
                         tick_.stride == 1 && !hasPendingBodyMotion(tick_);
  solveAndWalk(step);
  if (!divisible || !mayHaveJumped(tick_, before, glm::distance(tick_.hipAt(now), step.hip))) return;
  tick_.work.allowance.spend(kBisection);
  if (tick_.work.allowance.isSpent()) return;  // a step that is not made
  const Checkpoint after = tick_.checkpoint();
  const NearBodies::Points to = tick_.near.from();
  tick_.restore(before);
  tick_.near.moveAll(from, 1);
  const double until = heldUntil(tick_, now, step.end);
  if (until >= step.end) {
    tick_.restore(after);
    return tick_.near.moveAll(to, 1);
  }
  tick_.work.interrupted = interrupted;
  tick_.work.notConverged = notConverged;
  step.end = until;
  step.hip = tick_.hipAt(until);
  solveAndWalk(step);
}

/// Stores how far the tick came. One that made no step tries an eighth of its path in the next, where segments are
/// shorter and meet less.
void ContactTick::endSteps(double now) noexcept {
  constexpr double kShorter = 0x1p-3;
  constexpr double kMinStride = 0x1p-30;
  ContactState& state = tick_.state;
  if (!tick_.work.allowanceSpent) {
    state.stride = std::min(1.0, 2 * state.stride);
    now = 1;
  } else if (now == 0) {
    state.stride = std::max(kMinStride, state.stride * kShorter);
  }
  state.reached = now * tick_.stride;
  tick_.work.allowanceSpent = state.reached < 1;
  state.hip = tick_.hipAt(now);
  if (tick_.work.allowanceSpent) [[unlikely]] {
    tick_.setTime(now);
    if (tick_.near.count() == 1) carryWithBody();
  }
}

/// Where the allowance ends with one body in reach: HIP and IHIP go along with what is left of its motion, as that
/// changes nothing between the three, and the body does not pass over an IHIP that waits. The next tick goes on from
/// there.
void ContactTick::carryWithBody() noexcept {
  const Body& body = tick_.body(tick_.near[0].body);
  if (!body.moving) return;
  ContactState& state = tick_.state;
  const Pose tested = interpolate(body.previous, body.current, state.reached);
  for (Vec3* const point : {&state.hip, &state.ihip}) *point = toWorld(body.current, toLocal(tested, *point));
  tick_.near.setTime(tick_.bodies, 1);
  state.reached = 1;
}

/// Do bodies that close in on an IHIP that several surfaces hold leave it no step, however short, while the HIP moves less
/// than they do?
bool ContactTick::isOverrun() const noexcept {
  constexpr double kStuck = 0x1p-12;
  const ContactState& state = tick_.state;
  const Corrections& corrections = tick_.corrections;
  if (!corrections.containment || !corrections.objectFrameSegments) return false;
  if (state.mode != Mode::kSeveralSurfaces || state.reached >= 1 || state.stride > kStuck) return false;
  double carried = 0;
  for (int i = 0; i < tick_.near.count(); ++i) {
    const Body& body = tick_.body(tick_.near[i].body);
    if (!body.moving || body.pendingRemoval) continue;
    const Vec3 to = toWorld(body.current, toLocal(body.previous, state.ihip) + body.shift);
    carried = std::max(carried, glm::distance(to, state.ihip));
  }
  return carried > glm::distance(state.hip, tick_.goal);
}

/// They go to the end of their motion, and the IHIP is put outside of them, where the allowance lets such a place be found.
void ContactTick::letBodiesPass() noexcept {
  ContactState& state = tick_.state;
  const ContactState before = state;
  const Vec3 hip = tick_.hip;
  state.hip = tick_.hip = tick_.goal;
  state.reached = state.stride = 1;
  tick_.work.insideOf = enclosingBody(tick_);
  const bool isInside = tick_.work.insideOf >= 0;
  if (isInside) static_cast<void>(depenetrate());
  const bool isKnown = isInside ? tick_.work.depenetrated : !tick_.work.allowance.isSpent();
  if (!isKnown) {
    state = before;
    tick_.hip = hip;
    tick_.work.insideOf = -1;
    tick_.setTime(state.reached / tick_.stride);
  }
  state.containmentUnchecked = true;
}

void ContactTick::leaveEnclosingBody() noexcept {
  ContactState& state = tick_.state;
  if (tick_.work.allowanceSpent) {
    state.containmentUnchecked = state.containmentUnchecked || mayBeInside(tick_);
    if (isOverrun()) letBodiesPass();
    return;
  }
  if (state.containmentUnchecked || mayBeInside(tick_)) {
    tick_.work.insideOf = enclosingBody(tick_);
    const bool isOut = tick_.work.insideOf < 0 || depenetrate();
    state.containmentUnchecked = !isOut || tick_.work.allowance.isSpent();
  }
  state.reprojected = false;
}

/// Bodies that pass through each other can close a pocket on the IHIP. It is put where it is outside of all of them,
/// and the path of the HIP taken from there. False where it is not known to be out: there may be more of the allowance
/// in the next tick.
bool ContactTick::depenetrate() noexcept {
  const auto out = placeOutside(tick_);
  if (!out) return false;
  WalkStep step;
  step.end = 1;
  step.hip = tick_.hip;
  moveFree(1, step);
  if (tick_.work.allowance.isSpent()) {  // the bodies near there are not known
    tick_.setFree(*out);
    return false;
  }
  if (tick_.state.mode == Mode::kFree || (enclosingBody(tick_) < 0 && !tick_.work.allowance.isSpent())) return true;
  tick_.setSeveralSurfaces({});  // where it is outside, to be settled by the next tick
  tick_.state.ihip = *out;
  return false;
}

ContactResult ContactTick::result() noexcept {
  const ContactState& state = tick_.state;
  ContactResult result;
  result.ihip = state.ihip;
  result.work = tick_.work;
  if (state.mode == Mode::kFree) return result;
  if (recordedOnly_) {
    result.ihip = tick_.hip;
    return result;
  }
  const ContactSurface& held = tick_.held();
  const NearBodies::Near& near = tick_.nearOf(held);
  const Vec3 toIhip = state.ihip - tick_.goal;
  result.touching = true;
  result.body = held.body;
  if (state.mode == Mode::kOneSurface) {
    // Of a path that is not gone to its end the HIP may be outside of the plane already.
    result.alongNormal = tick_.footConverged && tick_.foot.feature == Feature::kPolygon && !tick_.work.allowanceSpent;
    result.penetration_m =
        result.alongNormal ? distanceFrom(near.surface->triangle(tick_.foot.triangle), near.frame.toLocal(tick_.goal))
                           : glm::length(toIhip);
    result.normal = near.frame.rotate(near.surface->normal(tick_.foot) * static_cast<double>(held.side));
  } else {
    result.penetration_m = glm::length(toIhip);
    tick_.foot = closestOn(near.surface->triangle(held.triangle), held.triangle, near.frame.toLocal(state.ihip));
    result.normal = result.penetration_m > 0
                        ? toIhip / result.penetration_m
                        : near.frame.rotate(near.surface->faceNormal(held.triangle) * static_cast<double>(held.side));
  }
  result.primitive = primitiveOf(*near.surface, tick_.foot);
  return result;
}

}  // namespace

void followGuarded(std::span<const Body> bodies, ContactState& state, const Vec3& hip, ContactResult& result,
                   const Corrections& corrections) noexcept {
  const Vec3 usable = isUsable(hip) ? hip : state.hip;  // one that is not has not moved
  TickContext tick(bodies, state, usable, result.work.allowance, corrections);
  result = ContactTick(tick).run();
}

}  // namespace haptics

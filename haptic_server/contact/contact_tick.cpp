// The tick in steps.

#include "haptic_server/contact/contact_tick.h"

#include <algorithm>
#include <cmath>

namespace haptics {

ContactTick::ContactTick(std::span<const Body> bodies, ContactState& state, Vec3 hip, const Allowance& allowance,
                         const Corrections& corrections) noexcept
    : corrections_(corrections),
      bodies_(bodies),
      state_(state),
      stride_(state.stride),
      hip_(state.stride < 1 ? glm::mix(state.hip, hip, state.stride) : hip),
      near_(corrections.segmentTest) {
  work_.allowance = allowance;
}

ContactResult ContactTick::run() noexcept {
  // What is kept of the allowance for finding out whether the IHIP is inside of a body, and for putting it out.
  const std::int64_t aside = work_.allowance.left() / 4;
  work_.allowance.spend(aside);
  start();
  makeSteps();
  work_.allowance.spend(-aside);
  if (work_.allowanceSpent) {
    state_.unchecked = state_.unchecked || mayBeInside();
    return result();
  }
  if (state_.unchecked || mayBeInside()) {
    work_.insideOf = enclosingBody();
    const bool isOut = work_.insideOf < 0 || depenetrate();
    state_.unchecked = !isOut || work_.allowance.isSpent();
  }
  state_.reprojected = false;
  return result();
}

ContactTick::Checkpoint ContactTick::checkpoint() const noexcept {
  return {state_.mode, state_.holdingCount, state_.holding, state_.feature, state_.local, state_.ihip, foot_, settled_};
}

void ContactTick::restore(const Checkpoint& before) noexcept {
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
void ContactTick::makeSteps() noexcept {
  constexpr double kShorter = 0x1p-3;
  constexpr double kMinStride = 0x1p-30;
  double now = 0;
  // Contacts and releases within a step may divide it again; a bound on all of them together bounds the tick.
  while (now < 1 && work_.steps < 2 * kMaxSteps) {
    const bool last = ++work_.steps >= kMaxSteps || work_.interrupted;
    const Checkpoint before = checkpoint();
    const double end = advance(now, last, before);
    if (work_.allowance.isSpent()) {
      restore(before);
      if (now == 0) state_.stride = std::max(kMinStride, state_.stride * kShorter);
      work_.allowanceSpent = true;
      break;
    }
    now = end;
  }
  if (!work_.allowanceSpent) {
    state_.stride = std::min(1.0, 2 * state_.stride);
    now = 1;
  }
  state_.reached = now * stride_;
  work_.allowanceSpent = state_.reached < 1;
  state_.hip = hipAt(now);
  if (work_.allowanceSpent) [[unlikely]] {
    setTime(now);
    if (near_.count() == 1) carryWithBody();
  }
}

/// Where the allowance ends with one body in reach: HIP and IHIP go along with what is left of its motion, as that changes
/// nothing between the three, and the body does not pass over an IHIP that waits. The next tick goes on from there.
void ContactTick::carryWithBody() noexcept {
  const Body& body = bodies_[static_cast<std::size_t>(near_[0].body)];
  if (!body.moving) return;
  const Pose tested = interpolate(body.previous, body.current, state_.reached);
  for (Vec3* const point : {&state_.hip, &state_.ihip}) *point = toWorld(body.current, toLocal(tested, *point));
  near_.setTime(bodies_, 1);
  state_.reached = 1;
}

void ContactTick::start() noexcept {
  near_.gather(bodies_, state_, hip_, work_);
  constexpr double kUsualExtent_m = 0.1;
  const double extent_m = corrections_.scaleFreeTolerances ? near_.extent_m() : kUsualExtent_m;
  skin_ = kSkin * extent_m;
  pathOffset_ = kPathOffset * extent_m;
  startOffset_ = kStartOffset * extent_m;
  if (!corrections_.objectFrameSegments) near_.setTime(bodies_, 1);
  const bool oneSurface = state_.mode == Mode::kOneSurface;
  if (oneSurface) {
    const Body& body = bodies_[static_cast<std::size_t>(held().body)];
    foot_ = heldFoot(*body.surface, state_, motionOver(body).from);
  }
  if (oneSurface && near_.count() == 1) return;  // no other body's frame to keep
  const Vec3 ihip = oneSurface ? heldNear().frame.toWorld(lifted(state_.local, held(), pathOffset_)) : state_.ihip;
  const Points from = near_.inEachFrame(ihip);
  near_.moveAll(from, 1);
}

/// The time to advance to where the HIP is followed by length: while several surfaces hold.
double ContactTick::shortStepEnd(double now) const noexcept {
  if (!corrections_.substeps || state_.holdingCount == 0) return 1;
  const Body& body = bodies_[static_cast<std::size_t>(held().body)];
  const double twiceArea2 = squaredLength(body.surface->triangle(held().triangle).areaNormal());
  const double step2 = body.moving ? squaredLength(toLocal(body.current, hip_) - toLocal(body.previous, state_.hip))
                                   : squaredLength(hip_ - state_.hip);
  if (inOneStep(step2, twiceArea2)) return 1;
  const double part = kStepFraction * std::sqrt(std::sqrt(twiceArea2) / step2);
  return std::min(1.0, now + std::max(part, kMinShortStep));
}

/// Returns the time reached; the end of the tick when this is its last step, unless something is touched on the way.
double ContactTick::advance(double now, bool last, const Checkpoint& before) noexcept {
  if (state_.mode == Mode::kOneSurface) return advanceOnSurface(now, last);
  const double end = state_.mode == Mode::kFree || last ? 1 : shortStepEnd(now);
  setTime(end);
  if (state_.mode == Mode::kFree) return advanceFree(now, end, hipAt(end));
  return advanceOnSeveral(now, end, before);
}

ContactResult ContactTick::result() noexcept {
  ContactResult result;
  result.ihip = state_.ihip;
  result.work = work_;
  if (state_.mode == Mode::kFree) return result;
  if (!corrections_.sameTickSearch && recordedOnly_) {
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
    result.normal = near.frame.rotate(near.surface->normal(foot_) * static_cast<double>(held().side));
  } else {
    const std::uint32_t t = held().triangle;
    result.penetration_m = glm::length(way);
    foot_ = closestOn(near.surface->triangle(t), t, near.frame.toLocal(state_.ihip));
    result.normal = result.penetration_m > 0
                        ? way / result.penetration_m
                        : near.frame.rotate(near.surface->faceNormal(t) * static_cast<double>(held().side));
  }
  result.primitive = primitiveOf(*near.surface, foot_);
  return result;
}

void followGuarded(std::span<const Body> bodies, ContactState& state, const Vec3& hip, ContactResult& result,
                   const Corrections& corrections) noexcept {
  const Vec3 usable = isUsable(hip) ? hip : state.hip;  // one that is not has not moved
  result = ContactTick(bodies, state, usable, result.work.allowance, corrections).run();
}

}  // namespace haptics

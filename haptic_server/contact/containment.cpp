// An IHIP that is inside of a body.

#include "haptic_server/contact/contact_tick.h"
#include "haptic_server/contact/depenetration.h"
#include "haptic_server/contact/nearest_foot.h"
#include "haptic_server/geometry/enclosure.h"

namespace haptics {

/// The path of the IHIP keeps it outside of bodies at rest. Moving ones can close in on it until the solver finds no way
/// out of theirs, a mesh that passes through itself has surface inside of itself, and an adoption puts bodies anywhere.
bool ContactTick::mayBeInside() const noexcept {
  if (!corrections_.containment || !corrections_.objectFrameSegments) return false;
  if (state_.reprojected || work_.notConverged || work_.droppedBodies > 0) return true;
  const bool alone = state_.mode == Mode::kOneSurface && near_.count() == 1;  // its own surface holds it
  for (int i = 0; i < near_.count(); ++i) {
    const Body& body = bodies_[static_cast<std::size_t>(near_[i].body)];
    if ((body.moving && !alone) || body.surface->anySelfIntersecting()) return true;
  }
  return false;
}

/// The closed body that the IHIP is inside of at the end of the tick, or the sheet that it is behind; -1 when there is none,
/// or when the allowance is spent.
int ContactTick::enclosingBody() noexcept {
  near_.setTime(bodies_, 1);
  work_.allowance.spend(Allowance::kSphere * static_cast<std::int64_t>(bodies_.size()));
  const int onSurface = state_.mode == Mode::kOneSurface ? held().body : -1;
  for (int b = 0; b < static_cast<int>(bodies_.size()) && !work_.allowance.isSpent(); ++b) {
    const Body& body = bodies_[static_cast<std::size_t>(b)];
    if (body.pendingRemoval || !body.surface->closed() || !withinSphere(body, state_.ihip)) continue;
    Vec3 at = body.frame.toLocal(state_.ihip);
    if (b == onSurface) {
      if (!body.surface->anySelfIntersecting()) continue;
      at = state_.local + body.surface->normal(foot_) * startOffset_;
    }
    ++work_.segments;
    if (windingNumber(*body.surface, at, work_.allowance) <= 0) continue;
    const ClosestPoint foot = nearestFoot(*body.surface, at, work_.allowance);
    if (work_.allowance.isSpent()) return -1;
    if (foot.squaredDistance > kDepthTolerance * kDepthTolerance * skin_ * skin_) return b;
  }
  for (int i = 0; i < near_.count() && !work_.allowance.isSpent(); ++i) {
    const Near& near = near_[i];
    if (near.surface->closed() || near.pendingRemoval || near.body == onSurface) continue;
    const Vec3 to = near.frame.toLocal(state_.ihip);
    if (near.from == to) continue;
    if (near_.crossing(near, to, work_)) return near.body;
  }
  return -1;
}

/// Bodies that pass through each other can close a pocket on the IHIP. It is put where it is outside of all of them, and
/// the path of the HIP taken from there. False where it is not known to be out: there may be more of the allowance in the
/// next tick.
bool ContactTick::depenetrate() noexcept {
  const Vec3 way = state_.ihip - hip_;
  const double depth = glm::length(way);
  const auto out = findDepenetration(bodies_, near_, state_.ihip, depth > 0 ? way / depth : Vec3(0), skin_, work_);
  if (!out) return false;
  work_.depenetrated = true;
  setFree(*out);
  near_.gather(bodies_, state_, hip_, work_);  // what is near there
  near_.setTime(bodies_, 1);
  near_.moveAll(near_.inEachFrame(*out), 1);
  (void)advanceFree(1, 1, hip_);
  if (work_.allowance.isSpent()) {  // what is near there is not known
    setFree(*out);
    return false;
  }
  if (state_.mode == Mode::kFree || (enclosingBody() < 0 && !work_.allowance.isSpent())) return true;
  state_.mode = Mode::kSeveralSurfaces;  // where it is outside, to be settled by the next tick
  state_.holdingCount = 0;
  state_.ihip = *out;
  return false;
}

}  // namespace haptics

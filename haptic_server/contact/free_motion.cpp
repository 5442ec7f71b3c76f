// A HIP in free space, and how it touches and leaves.

#include <algorithm>

#include "haptic_server/contact/contact_tick.h"

namespace haptics {

/// Paper 3.2, first contact: the segment between two places of the HIP against the bounding hierarchies. Deviations:
/// the segment is taken in each body's own frame, from where the HIP was in it to where it is, so that a body cannot
/// pass through a still HIP; all bodies advance to the instant of the earliest hit, and the search runs in the same
/// tick.
double ContactTick::advanceFree(double now, double end, Vec3 hip) noexcept {
  const Points to = near_.inEachFrame(hip);
  // Starts a hair behind on the way into closed bodies: a crossing lost to rounding where two ticks meet is seen now,
  // and the start only moves farther above all that can be entered. A sheet could be entered from its other side
  // instead; there the rule for points on the plane (Segment::enters) joins the segments.
  for (int i = 0; i < near_.count(); ++i) {
    const Vec3 way = to[static_cast<std::size_t>(i)] - near_[i].from;
    const double length = glm::length(way);
    if (length > 0 && near_[i].surface->closed()) near_[i].from -= way * (startOffset_ / length);
  }
  const Hit hit = firstNewContact(to, [](int, std::uint32_t) noexcept { return false; });
  if (!hit) {
    near_.moveAll(to, 1);
    setFree(hip);
    return end;
  }
  touch(hit, to);
  if (!corrections_.sameTickSearch) {
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
void ContactTick::touch(const Hit& hit, const Points& to) noexcept {
  const Near& near = near_[hit.near];
  const ContactSurface touched{near.body, hit.crossing.side, hit.crossing.triangle};
  if (isSelfIntersecting(touched)) {
    const double back = 2 * skin_ / glm::distance(near.from, to[static_cast<std::size_t>(hit.near)]);
    near_.moveAll(to, std::max(hit.crossing.time / 2, hit.crossing.time - back));
    state_.mode = Mode::kSeveralSurfaces;
    state_.holdingCount = 1;
    state_.holding[0] = touched;
    state_.ihip = near.frame.toWorld(near.from);
    return;
  }
  near_.moveAll(to, hit.crossing.time);
  ClosestPoint foot;
  foot.triangle = hit.crossing.triangle;
  foot.point = near.from;
  hold(touched, foot, near.frame.toWorld(near.from));
}

void ContactTick::setFree(Vec3 hip) noexcept {
  state_.mode = Mode::kFree;
  state_.holdingCount = 0;
  state_.ihip = hip;
}

void ContactTick::hold(const ContactSurface& surface, const ClosestPoint& foot, Vec3 ihip) noexcept {
  state_.mode = Mode::kOneSurface;
  state_.holdingCount = 1;
  state_.holding[0] = surface;
  state_.feature = foot.feature;
  state_.local = foot.point;
  state_.ihip = ihip;
  foot_ = foot;
  settled_ = false;
}

}  // namespace haptics

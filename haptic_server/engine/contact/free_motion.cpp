#include "haptic_server/engine/contact/free_motion.h"

namespace haptics {
namespace {

using Hit = NearBodies::Hit;
using Points = NearBodies::Points;

/// Bodies that are leaving the scene cannot be touched anew.
template <class Skip>
Hit firstNewContact(TickContext& tick, const Points& to, Skip skip) noexcept {
  return tick.near.firstHit(
      to, [&](int i, std::uint32_t t) noexcept { return tick.near[i].pendingRemoval || skip(i, t); }, tick.work);
}

/// To where the path enters; before a triangle that others pass through, a little less far: the solver starts from
/// there, off all of them.
void touch(TickContext& tick, const Hit& hit, const Points& to) noexcept {
  const NearBodies::Near& near = tick.near[hit.near];
  const ContactSurface touched{near.body, hit.crossing.side, hit.crossing.triangle};
  if (tick.isSelfIntersecting(touched)) {
    const double back = 2 * tick.skin / glm::distance(near.from, to[static_cast<std::size_t>(hit.near)]);
    tick.near.moveAll(to, std::max(hit.crossing.time / 2, hit.crossing.time - back));
    tick.setSeveralSurfaces({&touched, 1});
    tick.state.ihip = near.frame.toWorld(near.from);
    return;
  }
  tick.near.moveAll(to, hit.crossing.time);
  ClosestPoint foot;
  foot.triangle = hit.crossing.triangle;
  foot.point = near.from;
  tick.setOneSurface(touched, foot, near.frame.toWorld(near.from));
}

}  // namespace

/// Paper 3.2, first contact: the segment between two places of the HIP against the bounding hierarchies. Deviations:
/// the segment is taken in each body's own frame, from where the HIP was in it to where it is, so that a body cannot
/// pass through a still HIP; all bodies advance to the instant of the earliest hit.
double advanceFree(TickContext& tick, double now, double end, Vec3 hip) noexcept {
  NearBodies& near = tick.near;
  const Points to = near.inEachFrame(hip);
  // The segment starts a little behind on the way into closed bodies: a crossing lost to rounding where two ticks meet
  // is seen now, and the start only moves farther above all that can be entered. A sheet could be entered from its
  // other side instead; there the rule for points on the plane (Segment::enters) joins the segments.
  for (int i = 0; i < near.count(); ++i) {
    const Vec3 path = to[static_cast<std::size_t>(i)] - near[i].from;
    const double length = glm::length(path);
    if (length > 0 && near[i].surface->closed()) near[i].from -= path * (tick.startOffset / length);
  }
  const Hit hit = firstNewContact(tick, to, [](int, std::uint32_t) noexcept { return false; });
  if (!hit) {
    near.moveAll(to, 1);
    tick.setFree(hip);
    return end;
  }
  const double time = now + (end - now) * hit.crossing.time;
  tick.setTime(time);
  touch(tick, hit, to);
  return time;
}

/// Tested in the same tick: the path may lead into another tooth of a comb, or another body. The frame of a turning
/// body within the tick is not quite where h was found to be outside: the path leads to h.
void leaveSurface(TickContext& tick, const ClosestPoint& foot, Vec3 h, Vec3 hip) noexcept {
  const int own = tick.near.indexOf(tick.held().body);
  NearBodies::Near& near = tick.near[own];
  const CollisionMesh& s = *near.surface;
  const TriangleRecord& r = s.triangle(foot.triangle);
  // Triangles that hold the foot's primitive contain the start and cannot be entered again: exact, no tolerance needed.
  const auto holdsFoot = [&](int i, std::uint32_t t) noexcept {
    if (i != own) return false;
    const TriangleRecord& other = s.triangle(t);
    if (foot.feature == Feature::kPolygon) return t == foot.triangle;
    const bool atCorner = other.cornerOf(r.vertexAt(foot.index)) >= 0;
    if (foot.feature == Feature::kVertex) return atCorner;
    return atCorner && other.cornerOf(r.vertexAt(nextCorner(foot.index))) >= 0;
  };
  near.from = foot.point;
  // A sheet may have a duplicate in the same place, which a start below its rounding would enter from behind.
  if (!s.closed()) near.from += s.normal(foot) * (tick.held().side * tick.startOffset);
  Points to = tick.near.inEachFrame(hip);
  to[static_cast<std::size_t>(own)] = h;
  if (tick.corrections.exitRetest) {
    if (const Hit hit = firstNewContact(tick, to, holdsFoot)) return touch(tick, hit, to);
  }
  tick.near.moveAll(to, 1);
  tick.setFree(hip);
}

}  // namespace haptics

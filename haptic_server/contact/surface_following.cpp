// One surface: the neighborhood watch, guarded.

#include "haptic_server/contact/contact_tick.h"

namespace haptics {

HipMotion ContactTick::motionOver(const Body& body) const noexcept {
  if (!body.moving) return {body.frame.toLocal(state_.hip), body.frame.toLocal(hip_)};
  const Vec3 from = toLocal(body.previous, state_.hip);
  if (stride_ == 1) return {from, body.frame.toLocal(hip_)};
  return {from, toLocal(interpolate(body.previous, body.current, stride_), hip_)};
}

/// The neighborhood watch for h (body frame, metres).
SearchResult ContactTick::search(const ContactSurface& from, Vec3 h, SearchPath* path) noexcept {
  const int before = work_.triangles;
  const int budget = searchBudget(work_.allowance, work_.triangles);
  const SearchResult found =
      neighborhoodWatch(surface(from.body), from.triangle, h, path, work_.triangles, budget, corrections_);
  work_.allowance.spend(Allowance::kNearTriangle * (work_.triangles - before));
  return found;
}

/// Paper 3.2, the search and the test whether the HIP is still inside. Deviations:
///  - The sign is tested only once the search has converged, with the normal of the primitive that holds the foot.
///  - The path of the IHIP is guarded: "we constrain the IHIP such that it does not penetrate any object", but
///    neighbours know nothing of other objects, nor of another part of their own. Where something else is near, each
///    hop is tested. What crosses itself has no path that a search could follow: there the constraint solver takes over.
///  - The way out is tested in the same tick: it may lead into another tooth of a comb, or another body.
///  - At a boundary neither search nor sign mean anything: the constraint solver takes over.
double ContactTick::advanceOnSurface(double now, bool last) noexcept {
  const ContactSurface holding = held();
  const Body& body = bodies_[static_cast<std::size_t>(holding.body)];
  const HipMotion motion = motionOver(body);
  SearchPath path;
  SearchPath* const guarded = isGuarded(*body.surface) ? &path : nullptr;
  HipStep step{1, {}};
  const bool follows = corrections_.substeps && corrections_.featureCodes && corrections_.regionSteps;
  if (last || !follows) {
    step.end = last ? 1 : shortStepEnd(now);
    step.found = search(holding, motion.at(step.end), guarded);
  } else {
    const int before = work_.triangles;
    step = followHip(*body.surface, motion, holding.side, foot_, now, work_.steps, guarded, work_.triangles,
                     searchBudget(work_.allowance, before), corrections_);
    work_.allowance.spend(Allowance::kNearTriangle * (work_.triangles - before));
  }
  setTime(step.end);
  const Vec3 hip = hipAt(step.end);
  if (settle(step.found, path, motion.at(step.end), hip)) followSurface(hip);
  return step.end;
}

/// The search from a triangle that was touched just now.
void ContactTick::followSurface(Vec3 hip) noexcept {
  constexpr int kMaxTeeth = 4;  // left and entered again within a step; the next step goes on
  for (int i = 0; i < kMaxTeeth; ++i) {
    const Near& near = heldNear();
    const Vec3 h = near.frame.toLocal(hip);
    SearchPath path;
    SearchPath* const guarded = isGuarded(*near.surface) ? &path : nullptr;
    if (!settle(search(held(), h, guarded), path, h, hip)) return;
  }
}

/// The IHIP to where the search for h, the HIP in the body's frame, has led, unless something blocks the path, and off
/// the surface when h is outside. Returns whether another surface was touched then.
bool ContactTick::settle(const SearchResult& found, const SearchPath& path, Vec3 h, Vec3 hip) noexcept {
  const ContactSurface holding = held();
  const Near& near = heldNear();
  const CollisionMesh& s = *near.surface;
  const Frame& frame = near.frame;
  if (isGuarded(s) && !pathIsClear(path, frame)) {
    corrections_.severalSurfaces ? resolve(hip) : stayInPlace();
    return false;
  }
  hold({holding.body, holding.side, found.foot.triangle}, found.foot, frame.toWorld(found.foot.point));
  settled_ = found.converged;
  if (corrections_.severalSurfaces && s.onBoundary(found.foot)) {
    resolve(hip);
    return false;
  }
  work_.interrupted = work_.interrupted || !found.converged;
  if (!found.converged || !isOutside(s, found.foot, h)) return false;
  leave(found.foot, h, hip);
  return state_.mode == Mode::kOneSurface;
}

bool ContactTick::isOutside(const CollisionMesh& s, const ClosestPoint& foot, Vec3 h) const noexcept {
  ClosestPoint judged = foot;
  if (!corrections_.pseudonormals) judged.feature = Feature::kPolygon;
  return s.isOutside(judged, h, held().side);
}

/// Carries the IHIP with the contacted body, then along the path of the search, testing all others. Leaves triangle and
/// place at the last clear point when blocked.
bool ContactTick::pathIsClear(const SearchPath& path, const Frame& frame) noexcept {
  if (!path.complete()) return false;
  if (!pieceIsClear(held().triangle, state_.local, frame)) return false;
  for (const SearchPath::Point& point : path) {
    if (work_.allowance.isSpent() || !pieceIsClear(point.triangle, point.place, frame)) return false;
    state_.local = point.place;
    held().triangle = point.triangle;
  }
  return true;
}

bool ContactTick::pieceIsClear(std::uint32_t within, Vec3 b, const Frame& frame) noexcept {
  const Points to = near_.inEachFrame(frame.toWorld(lifted(b, {held().body, held().side, within}, pathOffset_)));
  work_.allowance.spend(Allowance::kPlace * near_.count());
  for (int i = 0; i < near_.count() && !work_.allowance.isSpent(); ++i) {
    const Near& near = near_[i];
    if (near.body == held().body) {
      if (near.surface->triangle(within).selfIntersecting()) return false;
      continue;
    }
    if (near_.crossing(near, to[static_cast<std::size_t>(i)], work_)) return false;
  }
  for (int i = 0; i < near_.count(); ++i) {
    if (near_[i].body != held().body) near_[i].from = to[static_cast<std::size_t>(i)];
  }
  return true;
}

/// Off the surface from its foot to h, the HIP in the body's frame, unless something is entered on the way. The frame of a
/// turning body within the tick is not quite where h was found to be outside: the way leads to h.
void ContactTick::leave(const ClosestPoint& foot, Vec3 h, Vec3 hip) noexcept {
  const int own = near_.indexOf(held().body);
  const CollisionMesh& s = *near_[own].surface;
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
  near_[own].from = foot.point;
  // A sheet may have a duplicate in the same place, which a start below its rounding would enter from behind.
  if (!s.closed()) near_[own].from += s.normal(foot) * (held().side * startOffset_);
  Points to = near_.inEachFrame(hip);
  to[static_cast<std::size_t>(own)] = h;
  const Hit hit = corrections_.exitRetest ? firstNewContact(to, holdsFoot) : Hit{};
  if (hit) {
    touch(hit, to);
    if (state_.mode == Mode::kSeveralSurfaces) solve(hip);
    return;
  }
  near_.moveAll(to, 1);
  setFree(hip);
}

}  // namespace haptics

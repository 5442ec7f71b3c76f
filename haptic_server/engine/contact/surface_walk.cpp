// One surface holds the IHIP. Paper 3.2, the search and the test whether the HIP is still inside. Deviations:
//  - The sign is tested only once the search has converged, with the normal of the primitive that holds the foot.
//  - The path of the IHIP is guarded: "we constrain the IHIP such that it does not penetrate any object", but
//    neighbours know nothing of other objects, nor of another part of their own. What crosses itself has no path that a
//    search could follow: there the plane solver takes over.
//  - At a boundary neither search nor sign mean anything: the plane solver takes over.

#include "haptic_server/engine/contact/surface_walk.h"

namespace haptics {
namespace {

bool isGuarded(const TickContext& tick, const CollisionMesh& surface) noexcept {
  return tick.corrections.guard && (tick.near.count() > 1 || surface.anySelfIntersecting());
}

/// @param end  Above the triangle; body frame.
bool pieceIsClear(TickContext& tick, std::uint32_t triangle, Vec3 end, const Frame& frame) noexcept {
  const ContactSurface& held = tick.held();
  NearBodies& near = tick.near;
  const NearBodies::Points to = near.inEachFrame(frame.toWorld(end));
  tick.work.allowance.spend(Allowance::kPlace * near.count());
  for (int i = 0; i < near.count() && !tick.work.allowance.isSpent(); ++i) {
    if (near[i].body == held.body) {
      if (near[i].surface->triangle(triangle).selfIntersecting()) return false;
      continue;
    }
    if (near.crossing(near[i], to[static_cast<std::size_t>(i)], tick.work)) return false;
  }
  for (int i = 0; i < near.count(); ++i) {
    if (near[i].body != held.body) near[i].from = to[static_cast<std::size_t>(i)];
  }
  return true;
}

/// Where the path goes over an edge that bends away, it is tested as far beyond the edge as no gap is wide: what is there
/// closes a thinner one, and the IHIP does not follow the surface down into it.
bool cornerIsClear(TickContext& tick, std::uint32_t next, const Frame& frame) noexcept {
  const ContactSurface& held = tick.held();
  const CollisionMesh& surface = tick.surface(held.body);
  const Vec3 normal = surface.faceNormal(held.triangle), beyond = surface.faceNormal(next);
  if (glm::dot(normal, beyond) > kBend) return true;
  const Vec3 corner = normal * tick.pathOffset + beyond * (kGap * tick.skin);
  return pieceIsClear(tick, held.triangle, tick.state.local + corner * static_cast<double>(held.side), frame);
}

/// Carries the IHIP with the contacted body, then along the path, testing all others. Leaves triangle and place at the
/// last clear point when blocked.
bool pathIsClear(TickContext& tick, const SearchPath& path, const Frame& frame) noexcept {
  if (!path.complete()) return false;
  const auto above = [&](const SearchPath::Point& point) noexcept {
    return tick.lifted(point.place, {tick.held().body, tick.held().side, point.triangle}, tick.pathOffset);
  };
  const SearchPath::Point start{tick.state.local, tick.held().triangle};
  if (!pieceIsClear(tick, start.triangle, above(start), frame)) return false;
  for (const SearchPath::Point& point : path) {
    if (tick.work.allowance.isSpent() || !cornerIsClear(tick, point.triangle, frame) ||
        !pieceIsClear(tick, point.triangle, above(point), frame))
      return false;
    tick.state.local = point.place;
    tick.held().triangle = point.triangle;
  }
  return true;
}

/// The search, with the corrections that this tick has.
SearchResult watch(TickContext& tick, const CollisionMesh& surface, std::uint32_t from, Vec3 h, SearchPath* path,
                   int budget) noexcept {
  SearchRun run{budget, tick.work.triangles, path};
  const SearchResult found = tick.corrections.ablateSearch() ? ablatedWatch(surface, from, h, run, tick.corrections)
                                                             : neighborhoodWatch(surface, from, h, run);
  tick.countLooked(run);
  return found;
}

}  // namespace

HipMotion hipMotion(const TickContext& tick) noexcept {
  const Body& body = tick.body(tick.held().body);
  if (!body.moving) return {body.frame.toLocal(tick.state.hip), body.frame.toLocal(tick.hip)};
  const Vec3 from = toLocal(body.previous, tick.state.hip);
  if (tick.stride == 1) return {from, body.frame.toLocal(tick.hip)};
  return {from, toLocal(interpolate(body.previous, body.current, tick.stride), tick.hip)};
}

double shortStepEnd(const TickContext& tick, double now) noexcept {
  if (!tick.corrections.substeps || tick.state.holdingCount == 0) return 1;
  const Body& body = tick.body(tick.held().body);
  const double twiceArea2 = squaredLength(body.surface->triangle(tick.held().triangle).areaNormal());
  const double step2 = body.moving
                           ? squaredLength(toLocal(body.current, tick.hip) - toLocal(body.previous, tick.state.hip))
                           : squaredLength(tick.hip - tick.state.hip);
  if (inOneStep(step2, twiceArea2)) return 1;
  const double fraction = kStepFraction * std::sqrt(std::sqrt(twiceArea2) / step2);
  return std::min(1.0, now + std::max(fraction, kMinShortStep));
}

void stepOverRegions(TickContext& tick, double now, bool last, WalkStep& step) noexcept {
  const ContactSurface& held = tick.held();
  const CollisionMesh& surface = tick.surface(held.body);
  const HipMotion motion = hipMotion(tick);
  const Corrections& on = tick.corrections;
  step.guarded = isGuarded(tick, surface);
  step.budget = searchBudget(tick.work.allowance, tick.work.triangles);
  if (last || !(on.substeps && on.featureCodes && on.regionSteps)) {
    step.end = last ? 1 : shortStepEnd(tick, now);
    step.found = {{held.triangle}, false};
  } else {
    step.found = {tick.foot, false};
    SearchRun run{step.budget, tick.work.triangles, step.guardedPath()};
    step.end = leaveRegion(surface, motion, held.side, now, tick.work.steps, step.found, run);
    tick.countLooked(run);
  }
  step.h = motion.at(step.end);
  step.hip = tick.hipAt(step.end);
  tick.setTime(step.end);
}

void settle(TickContext& tick, WalkStep& step) noexcept {
  tick.settled = true;
  step.end = 0;
  step.hip = tick.state.hip;
  tick.setTime(0);
  searchAnew(tick, step);
}

void searchAnew(const TickContext& tick, WalkStep& step) noexcept {
  const NearBodies::Near& near = tick.nearOf(tick.held());
  step.h = near.frame.toLocal(step.hip);
  step.found = {{tick.held().triangle}, false};
  step.budget = searchBudget(tick.work.allowance, tick.work.triangles);
  step.guarded = isGuarded(tick, *near.surface);
  step.path.keepFirst(0);
}

void search(TickContext& tick, WalkStep& step) noexcept {
  if (step.found.converged) return;
  const CollisionMesh& surface = tick.surface(tick.held().body);
  step.found = watch(tick, surface, step.found.foot.triangle, step.h, step.guardedPath(), step.budget);
}

SearchResult search(TickContext& tick, const ContactSurface& from, Vec3 h, SearchPath* path) noexcept {
  const int budget = searchBudget(tick.work.allowance, tick.work.triangles);
  return watch(tick, tick.surface(from.body), from.triangle, h, path, budget);
}

bool followPath(TickContext& tick, WalkStep& step) noexcept {
  const ContactSurface held = tick.held();
  const NearBodies::Near& near = tick.nearOf(held);
  const ClosestPoint& foot = step.found.foot;
  if (step.guarded && !pathIsClear(tick, step.path, near.frame)) return false;
  tick.setOneSurface({held.body, held.side, foot.triangle}, foot, near.frame.toWorld(foot.point));
  tick.footConverged = step.found.converged;
  if (tick.corrections.severalSurfaces && near.surface->onBoundary(foot)) return false;
  tick.work.interrupted = tick.work.interrupted || !step.found.converged;
  return true;
}

bool isOutside(TickContext& tick, const WalkStep& step) noexcept {
  if (!step.found.converged) return false;
  ClosestPoint judged = step.found.foot;
  if (!tick.corrections.pseudonormals) judged.feature = Feature::kPolygon;
  return tick.surface(tick.held().body).isOutside(judged, step.h, tick.held().side);
}

}  // namespace haptics

#include <algorithm>

#include "haptic_server/engine/contact/fast_path/fast_path.h"
#include "haptic_server/engine/contact/fast_path/triangle_walk.h"
#include "haptic_server/engine/contact/hip_following.h"
#include "haptic_server/engine/contact/tolerances.h"

namespace haptics {
namespace {

/// False when a body moves, or when there are more than a tick looks at.
bool findOthers(std::span<const Body> bodies, const ContactState& state, Vec3 hip, NearbyBodies& others,
                Allowance& allowance) noexcept {
  allowance.spend(Allowance::kPlace * static_cast<std::int64_t>(bodies.size()));
  if (allowance.isSpent()) return false;
  const double reach = reachOf(state, hip);
  const Body* held = &bodies[static_cast<std::size_t>(state.holding[0].body)];
  for (const Body& body : bodies) {
    if (body.moving) return false;
    if (&body == held || body.pendingRemoval || !squaredGap(body, hip, reach)) continue;
    if (others.count == others.body.size()) return false;
    others.body[others.count++] = &body;
  }
  return true;
}

/// The guard (surface_walk.cpp) of a body at rest that crosses itself nowhere. `normal` is that of the held triangle.
[[gnu::noinline]] bool pathIsClear(const Body& body, const NearbyBodies& others, const ContactState& state, Vec3 normal,
                                   const SearchPath& path, Allowance& allowance) noexcept {
  if (!path.complete()) return false;
  double extent = body.extent_m;
  for (const Body* other : others.all()) extent = std::max(extent, other->extent_m);
  std::uint32_t triangle = state.holding[0].triangle;
  Vec3 lift = normal * (state.holding[0].side * (kPathOffset * extent));
  Vec3 from = body.frame.toWorld(state.local + lift);
  for (const SearchPath::Point& point : path) {
    if (point.triangle != triangle) {
      triangle = point.triangle;
      const Vec3 next = body.surface->faceNormal(triangle);
      if (glm::dot(normal, next) <= kBend) return false;  // where a gap may be
      normal = next;
      lift = normal * (state.holding[0].side * (kPathOffset * extent));
    }
    const Vec3 to = body.frame.toWorld(point.place + lift);
    for (const Body* other : others.all()) {
      const CollisionMesh& surface = *other->surface;  // one that is passed within a rim may close a gap
      if (surface.firstCrossing<RimmedSegment>(
              other->frame.toLocal(from), other->frame.toLocal(to), !surface.closed(), allowance,
              [](std::uint32_t) noexcept { return false; }, kRim * surface.extent_m()))
        return false;
      if (allowance.isSpent()) return false;
    }
    from = to;
  }
  return true;
}

/// A line or vertex holds the IHIP, or other bodies are in reach. False when a search does not
/// converge, where the HIP is not held, or when something blocks the path.
[[nodiscard, gnu::noinline]] bool followBySearch(const Body& body, const NearbyBodies& others, ContactState& state,
                                                 const Vec3& hip, ContactResult& result) noexcept {
  const CollisionMesh& surface = *body.surface;
  const int side = state.holding[0].side;
  const HipMotion motion{body.frame.toLocal(state.hip), body.frame.toLocal(hip)};
  const bool guarded = others.count > 0;
  SearchPath path;
  SearchRun run{.budget = searchBudget(result.work.allowance), .path = guarded ? &path : nullptr};
  int steps = 0;
  ClosestPoint foot = heldFoot(surface, state, motion.from);
  const auto spend = [&] { result.work.allowance.spend(Allowance::kNearTriangle * run.looked); };
  for (double now = 0; now < 1;) {
    if (++steps == kMaxSteps) return spend(), false;
    const HipStep step = followHip(surface, motion, side, foot, now, steps, run);
    now = step.end;
    foot = step.found.foot;
    if (!step.found.converged || surface.onBoundary(foot)) return spend(), false;
    if (surface.isOutside(foot, motion.at(now), side)) return spend(), false;
  }
  spend();
  if (guarded &&
      !pathIsClear(body, others, state, surface.faceNormal(state.holding[0].triangle), path, result.work.allowance)) {
    return false;
  }
  result.work.triangles = run.looked;
  result.work.steps = steps;
  result.work.segments =
      static_cast<int>(others.count * (static_cast<std::size_t>(steps) + path.size()));  // each starts with one
  result.primitive = primitiveOf(surface, foot);
  storeContact(body, state, hip, {foot.triangle, foot.feature, toDouble4(foot.point), toDouble4(surface.normal(foot))},
               result);
  result.alongNormal = foot.feature == Feature::kPolygon;
  result.penetration_m =
      result.alongNormal ? distanceFrom(surface.triangle(foot.triangle), motion.to) : glm::length(state.ihip - hip);
  return true;
}

}  // namespace

bool footIsClear(const Body& body, const NearbyBodies& others, const ContactState& state, const Vec3& foot,
                 ContactWork& work) noexcept {
  const std::uint32_t triangle = state.holding[0].triangle;
  SearchPath path;
  path.add(foot, triangle);
  work.segments = static_cast<int>(2 * others.count);
  return pathIsClear(body, others, state, body.surface->faceNormal(triangle), path, work.allowance);
}

bool stepOverTriangles(const Body& body, ContactState& state, const CachedTriangle& polygon, const Vec3& hip,
                       const Vec3& h, const Prism::Coordinates& beyond, ContactResult& result,
                       ContactCache& cache) noexcept {
  const int side = state.holding[0].side;
  const Vec3x4 from = broadcast(body.frame.toLocal(state.hip));
  Prism::Coordinates end = beyond;
  int looked = 1;
  const int most = searchBudget(result.work.allowance) - 1;
  const CachedTriangle* const found =
      walkTriangles(*body.surface, polygon, cache.polygon, from, broadcast(h), side, most, end, looked, cache.ahead);
  result.work.allowance.spend(Allowance::kNearTriangle * looked);
  if (found == nullptr || end.isOutside(side)) return false;
  finishOnTriangle(body, state, *found, hip, h, end, looked, result);
  return true;
}

bool loadHeld(const Body& body, const ContactState& state, ContactCache& cache) noexcept {
  const std::uint32_t triangle = state.holding[0].triangle;
  if (body.surface->anySelfIntersecting() || body.surface->triangle(triangle).zeroArea()) return false;
  cache.polygon.load(*body.surface, triangle);
  return true;
}

bool followUnblocked(std::span<const Body> bodies, ContactState& state, const Vec3& hip, ContactResult& result,
                     ContactCache& cache) noexcept {
  const Body& body = bodies[static_cast<std::size_t>(state.holding[0].body)];
  const CollisionMesh& surface = *body.surface;
  const std::uint32_t held = state.holding[0].triangle;
  if (body.moving || state.unfinished || surface.anySelfIntersecting() || surface.triangle(held).zeroArea())
    return false;
  NearbyBodies others;
  if (bodies.size() > 1 && !findOthers(bodies, state, hip, others, result.work.allowance)) return false;
  if (state.feature == Feature::kPolygon && bodies.size() > 1) {  // of one body stayOnPolygon() has tried
    if (!cache.polygon.is(surface, held)) cache.polygon.load(surface, held);
    const NearbyBodies* const beside = others.count > 0 ? &others : nullptr;
    if (followOnTriangle(body, state, cache.polygon, hip, result, cache, beside)) return true;
  }
  return followBySearch(body, others, state, hip, result);
}

}  // namespace haptics

// The guarded neighborhood watch (surface_following.cpp) for the case that it has nothing to guard against.

#include <algorithm>

#include "haptic_server/contact/contact_tick.h"
#include "haptic_server/contact/fast_path/clearance.h"
#include "haptic_server/contact/fast_path/fast_path.h"
#include "haptic_server/contact/fast_path/triangle_walk.h"
#include "haptic_server/contact/hip_following.h"

namespace haptics {
namespace {

/// The bodies that NearBodies::gather() would find beside the held one.
struct Others {
  std::array<const Body*, kMaxNear - 1> body;
  std::size_t count = 0;

  [[nodiscard]] std::span<const Body* const> all() const noexcept { return std::span(body).first(count); }
};

/// False when a body moves, or when there are more than a tick looks at.
bool findOthers(std::span<const Body> bodies, const ContactState& state, Vec3 hip, Others& others,
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

/// ContactTick::pathIsClear() of a held body at rest that crosses itself nowhere. `normal` is that of the held triangle.
[[gnu::noinline]] bool pathIsClear(const Body& body, const Others& others, const ContactState& state, Vec3 normal,
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
      lift = body.surface->faceNormal(triangle) * (state.holding[0].side * (kPathOffset * extent));
    }
    const Vec3 to = body.frame.toWorld(point.place + lift);
    for (const Body* other : others.all()) {
      if (other->surface->firstCrossing(other->frame.toLocal(from), other->frame.toLocal(to), allowance)) return false;
      if (allowance.isSpent()) return false;
    }
    from = to;
  }
  return true;
}

/// Axes and origin of a Frame, to turn and carry with its operations.
struct WideFrame {
  Double4 x, y, z, origin;

  explicit WideFrame(const Frame& f) noexcept
      : x(toDouble4(f.x)), y(toDouble4(f.y)), z(toDouble4(f.z)), origin(toDouble4(f.origin)) {}
  [[nodiscard]] Double4 rotate(Double4 local) const noexcept {
    return x * broadcastLane<0>(local) + y * broadcastLane<1>(local) + z * broadcastLane<2>(local);
  }
};

/// Where the neighborhood watch ends.
struct Minimum {
  std::uint32_t triangle;
  Feature feature;
  Double4 foot;
  Double4 normal;
};

/// What a tick over one surface hands on. Inline, each value a store of its own: where values are put together in
/// memory and taken out again in larger pieces, the processor waits for every store.
[[gnu::always_inline]] inline void storeContact(const Body& body, ContactState& state, const Vec3& hip,
                                                const Minimum& minimum, ContactResult& result) noexcept {
  const WideFrame frame(body.frame);
  const Vec3 ihip = vec3(frame.rotate(minimum.foot) + frame.origin);
  ContactSurface& holding = state.holding[0];
  result.touching = true;
  result.body = holding.body;
  result.ihip = ihip;
  result.normal = vec3(frame.rotate(minimum.normal * broadcast(holding.side)));
  holding.triangle = minimum.triangle;
  state.feature = minimum.feature;
  state.local = vec3(minimum.foot);
  state.ihip = ihip;
  state.hip = hip;
}

/// Beside others, without a change of polygon.
[[nodiscard, gnu::noinline]] bool finishIsClear(const Body& body, const Others& others, const ContactState& state,
                                                const Vec3& foot, ContactWork& work) noexcept {
  const std::uint32_t triangle = state.holding[0].triangle;
  SearchPath path;
  path.add(foot, triangle);
  work.segments = static_cast<int>(2 * others.count);
  return pathIsClear(body, others, state, body.surface->faceNormal(triangle), path, work.allowance);
}

/// A tick that ends over the polygon, at this place in its frame, and inside of the surface.
[[gnu::always_inline]] inline void finishOnTriangle(const Body& body, ContactState& state,
                                                    const CachedTriangle& polygon, const Vec3& hip, const Vec3& h,
                                                    const Prism::Coordinates& end, int looked,
                                                    ContactResult& result) noexcept {
  result.work.triangles = looked;
  result.work.steps = 1;
  result.primitive = {PrimitiveKind::kPolygon, 0, polygon.canonical};
  const Double4 foot = polygon.foot(toDouble4(h), end.height());
  result.alongNormal = true;
  result.penetration_m = polygon.distance(end.height());
  storeContact(body, state, hip, {polygon.triangle, Feature::kPolygon, foot, polygon.unitNormal}, result);
}

/// From polygon to polygon, as followOverPolygons() does: a tick that ends beyond the polygon, at this place in its frame.
/// False when there is more to it.
[[nodiscard, gnu::noinline]] bool stepOverTriangles(const Body& body, ContactState& state,
                                                    const CachedTriangle& polygon, const Vec3& hip, const Vec3& h,
                                                    const Prism::Coordinates& beyond, ContactResult& result,
                                                    const TriangleCache* cache) noexcept {
  const int side = state.holding[0].side;
  const Vec3x4 from = broadcast(body.frame.toLocal(state.hip));
  Prism::Coordinates end = beyond;
  int looked = 1;
  const int most = searchBudget(result.work.allowance) - 1;
  const CachedTriangle* const found =
      walkTriangles(*body.surface, polygon, state.polygon, from, broadcast(h), side, most, end, looked, cache);
  result.work.allowance.spend(Allowance::kNearTriangle * looked);
  if (found == nullptr || end.isOutside(side)) return false;
  finishOnTriangle(body, state, *found, hip, h, end, looked, result);
  return true;
}

/// From a polygon to where the HIP is above it, or above others: beside `others`, when there are any, above it only. False
/// when there is more to it.
[[nodiscard, gnu::always_inline]] inline bool followOnTriangle(const Body& body, ContactState& state,
                                                               const CachedTriangle& polygon, const Vec3& hip,
                                                               ContactResult& result, const TriangleCache* cache,
                                                               const Others* others) noexcept {
  const Vec3 h = body.frame.toLocal(hip);
  const Prism::Coordinates end = polygon.prism.coordinates(broadcast(h));
  if (end.beyond() != 0) [[unlikely]] {
    const Vec3 place = h;  // copies, so that the others stay in registers
    const Prism::Coordinates beyond = end;
    return others == nullptr && stepOverTriangles(body, state, polygon, hip, place, beyond, result, cache);
  }
  if (end.isOutside(state.holding[0].side)) [[unlikely]]
    return false;
  if (others != nullptr) {
    const Vec3 foot = vec3(polygon.foot(toDouble4(h), end.height()));
    if (!finishIsClear(body, *others, state, foot, result.work)) return false;
  }
  finishOnTriangle(body, state, polygon, hip, h, end, 1, result);
  return true;
}

/// A line or vertex holds the IHIP, or other bodies are in reach. False when a search ends nowhere, where the HIP is not
/// held, or when something blocks the way.
[[nodiscard, gnu::noinline]] bool followBySearch(const Body& body, const Others& others, ContactState& state,
                                                 const Vec3& hip, ContactResult& result) noexcept {
  const CollisionMesh& surface = *body.surface;
  const int side = state.holding[0].side;
  const HipMotion motion{body.frame.toLocal(state.hip), body.frame.toLocal(hip)};
  const bool guarded = others.count > 0;
  const int budget = searchBudget(result.work.allowance);
  SearchPath path;
  int looked = 0;
  int steps = 0;
  ClosestPoint foot = heldFoot(surface, state, motion.from);
  const auto spend = [&] { result.work.allowance.spend(Allowance::kNearTriangle * looked); };
  for (double now = 0; now < 1;) {
    if (++steps == kMaxSteps) return spend(), false;
    const HipStep step = followHip(surface, motion, side, foot, now, steps, guarded ? &path : nullptr, looked, budget);
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
  result.work.triangles = looked;
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

/// The common tick of all: alone, from a polygon that is kept from the last tick, or known. Of a HIP that is usable.
[[nodiscard, gnu::always_inline]] inline bool stayOnTriangle(std::span<const Body> bodies, ContactState& state,
                                                             const Vec3& hip, ContactResult& result,
                                                             const TriangleCache* cache) noexcept {
  if (bodies.size() != 1 || state.feature != Feature::kPolygon) return false;
  const ContactSurface& holding = state.holding[0];
  const Body& body = bodies[static_cast<std::size_t>(holding.body)];
  if (body.moving) return false;
  const CachedTriangle* polygon = &state.polygon;
  if (!polygon->is(*body.surface, holding.triangle)) {
    polygon = cache != nullptr ? cache->find(*body.surface, holding.triangle) : nullptr;
    if (polygon == nullptr) return false;
  }
  return followOnTriangle(body, state, *polygon, hip, result, cache, nullptr);
}

/// All that there can be to it otherwise, while one surface holds. Of a HIP that is usable.
[[nodiscard]] bool followNearOthers(std::span<const Body> bodies, ContactState& state, const Vec3& hip,
                                    ContactResult& result) noexcept {
  const Body& body = bodies[static_cast<std::size_t>(state.holding[0].body)];
  const CollisionMesh& surface = *body.surface;
  if (body.moving || surface.anySelfIntersecting() || surface.triangle(state.holding[0].triangle).zeroArea())
    return false;
  // Where the whole way takes more than the allowance, or it is to be seen whether the IHIP is inside of another body.
  if (state.stride < 1 || state.unchecked) return false;
  Others others;
  if (bodies.size() > 1 && !findOthers(bodies, state, hip, others, result.work.allowance)) return false;
  if (state.feature == Feature::kPolygon) {
    const std::uint32_t triangle = state.holding[0].triangle;
    if (!state.polygon.is(surface, triangle)) state.polygon.load(surface, triangle);
    const Others* const beside = others.count > 0 ? &others : nullptr;
    if (followOnTriangle(body, state, state.polygon, hip, result, nullptr, beside)) return true;
  }
  return followBySearch(body, others, state, hip, result);
}

[[gnu::noinline]] bool followInGeneral(std::span<const Body> bodies, ContactState& state, const Vec3& hip,
                                       ContactResult& result) noexcept {
  if (isUsable(hip) && followNearOthers(bodies, state, hip, result)) return true;
  followGuarded(bodies, state, hip, result);
  return false;
}

/// Free, or held by several surfaces.
bool followFreeOrSeveral(std::span<const Body> bodies, ContactState& state, const Vec3& hip,
                         ContactResult& result) noexcept {
  if (state.clear.radius_m > 0 && staysClear(bodies, state, hip)) {
    state.hip = state.ihip = result.ihip = hip;
    return true;
  }
  const Vec3 before = state.hip;
  const bool wasFree = state.mode == ContactState::Mode::kFree;
  followGuarded(bodies, state, hip, result);
  const bool settled = !result.work.allowanceSpent && !result.work.depenetrated && !state.unchecked;
  if (wasFree && settled && state.mode == ContactState::Mode::kFree) {
    lookForClearance(bodies, state, glm::distance(before, state.hip), result.work.allowance);
  }
  return false;
}

}  // namespace

bool followFast(std::span<const Body> bodies, ContactState& state, const Vec3& hip, ContactResult& result,
                const TriangleCache* cache) noexcept {
  if (state.mode != ContactState::Mode::kOneSurface) return followFreeOrSeveral(bodies, state, hip, result);
  if (isUsable(hip) && stayOnTriangle(bodies, state, hip, result, cache)) [[likely]]
    return true;
  return followInGeneral(bodies, state, hip, result);
}

}  // namespace haptics

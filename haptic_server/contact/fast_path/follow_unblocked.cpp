// The guarded neighborhood watch (surface_following.cpp) for the case that it has nothing to guard against.

#include <algorithm>

#include "haptic_server/contact/contact_tick.h"
#include "haptic_server/contact/fast_path/clearance.h"
#include "haptic_server/contact/fast_path/fast_path.h"
#include "haptic_server/contact/fast_path/over_polygon.h"
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
  const double reach = reachOf(state, hip);
  const Body* held = &bodies[static_cast<std::size_t>(state.holding[0].body)];
  for (const Body& body : bodies) {
    if (body.moving) return false;
    if (&body == held || body.leaving || !squaredGap(body, hip, reach)) continue;
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
  Vec3 lift = normal * (state.holding[0].side * (kPathLift * extent));
  Vec3 from = body.frame.toWorld(state.local + lift);
  for (const SearchPath::Point& point : path) {
    if (point.triangle != triangle) {
      triangle = point.triangle;
      lift = body.surface->faceNormal(triangle) * (state.holding[0].side * (kPathLift * extent));
    }
    const Vec3 to = body.frame.toWorld(point.place + lift);
    for (const Body* other : others.all()) {
      if (other->surface->firstCrossing(other->frame.toLocal(from), other->frame.toLocal(to), allowance)) return false;
    }
    if (allowance.isSpent()) return false;
    from = to;
  }
  return true;
}

/// Axes and origin of a Frame, to turn and carry with its operations.
struct WideFrame {
  Four x, y, z, origin;

  explicit WideFrame(const Frame& f) noexcept : x(four(f.x)), y(four(f.y)), z(four(f.z)), origin(four(f.origin)) {}
  [[nodiscard]] Four turn(Four local) const noexcept {
    return x * allOf<0>(local) + y * allOf<1>(local) + z * allOf<2>(local);
  }
};

/// Where the neighborhood watch ends.
struct Minimum {
  std::uint32_t triangle;
  Feature feature;
  Four foot;
  Four normal;
};

/// What a tick over one surface hands on. Inline, each value a store of its own: where values are put together in
/// memory and taken out again in larger pieces, the processor waits for every store.
[[gnu::always_inline]] inline void keep(const Body& body, ContactState& state, const Vec3& hip, const Minimum& minimum,
                                        ContactResult& result) noexcept {
  const WideFrame frame(body.frame);
  const Vec3 ihip = vec3(frame.turn(minimum.foot) + frame.origin);
  HoldingSurface& holding = state.holding[0];
  result.touching = true;
  result.body = holding.body;
  result.ihip = ihip;
  result.normal = vec3(frame.turn(minimum.normal * all(holding.side)));
  holding.triangle = minimum.triangle;
  state.feature = minimum.feature;
  state.local = vec3(minimum.foot);
  state.ihip = ihip;
  state.hip = hip;
}

/// Beside others, without a change of polygon.
[[nodiscard, gnu::noinline]] bool stayIsClear(const Body& body, const Others& others, const ContactState& state,
                                              const Vec3& foot, ContactWork& work) noexcept {
  const std::uint32_t triangle = state.holding[0].triangle;
  SearchPath path;
  path.add(foot, triangle);
  work.segments = static_cast<int>(2 * others.count);
  return pathIsClear(body, others, state, body.surface->faceNormal(triangle), path, work.allowance);
}

/// A tick that ends over the polygon, at this place in its frame, and inside of the surface.
[[gnu::always_inline]] inline void stay(const Body& body, ContactState& state, const HeldPolygon& polygon,
                                        const Vec3& hip, const Vec3& h, const Prism::Place& end, int looked,
                                        ContactResult& result) noexcept {
  result.work.triangles = looked;
  result.work.steps = 1;
  result.primitive = {PrimitiveKind::kPolygon, 0, polygon.canonical};
  const Four foot = polygon.foot(four(h), end.height());
  result.alongNormal = true;
  result.penetration_m = polygon.distance(end.height());
  keep(body, state, hip, {polygon.triangle, Feature::kPolygon, foot, polygon.unitNormal}, result);
}

/// From polygon to polygon, as followOverPolygons() does: a tick that ends beyond the polygon, at this place in its frame.
/// False when there is more to it.
[[nodiscard, gnu::noinline]] bool hop(const Body& body, ContactState& state, const HeldPolygon& polygon,
                                      const Vec3& hip, const Vec3& h, const Prism::Place& beyond, ContactResult& result,
                                      const KnownPolygons* known) noexcept {
  const int side = state.holding[0].side;
  const FourVec3 from = all(body.frame.toLocal(state.hip));
  Prism::Place end = beyond;
  int looked = 1;
  const int most = searchBudget(result.work.allowance) - 1;
  const HeldPolygon* const found =
      hopOverPolygons(*body.surface, polygon, state.polygon, from, all(h), side, most, end, looked, known);
  result.work.allowance.spend(Allowance::kNearTriangle * looked);
  if (found == nullptr || end.isOutside(side)) return false;
  stay(body, state, *found, hip, h, end, looked, result);
  return true;
}

/// From a polygon to where the HIP is above it, or above others: beside `others`, when there are any, above it only. False
/// when there is more to it.
[[nodiscard, gnu::always_inline]] inline bool goStraight(const Body& body, ContactState& state,
                                                         const HeldPolygon& polygon, const Vec3& hip,
                                                         ContactResult& result, const KnownPolygons* known,
                                                         const Others* others) noexcept {
  const Vec3 h = body.frame.toLocal(hip);
  const Prism::Place end = polygon.prism.place(all(h));
  if (end.beyond() != 0) [[unlikely]] {
    const Vec3 place = h;  // copies, so that the others stay in registers
    const Prism::Place beyond = end;
    return others == nullptr && hop(body, state, polygon, hip, place, beyond, result, known);
  }
  if (end.isOutside(state.holding[0].side)) [[unlikely]]
    return false;
  if (others != nullptr) {
    const Vec3 foot = vec3(polygon.foot(four(h), end.height()));
    if (!stayIsClear(body, *others, state, foot, result.work)) return false;
  }
  stay(body, state, polygon, hip, h, end, 1, result);
  return true;
}

/// A line or vertex holds the IHIP, or other bodies are in reach. False when a search ends nowhere, where the HIP is not
/// held, or when something blocks the way.
[[nodiscard, gnu::noinline]] bool searchBeside(const Body& body, const Others& others, ContactState& state,
                                               const Vec3& hip, ContactResult& result) noexcept {
  const Surface& surface = *body.surface;
  const int side = state.holding[0].side;
  const HipMotion motion{body.frame.toLocal(state.hip), body.frame.toLocal(hip)};
  const bool guarded = others.count > 0;
  const int budget = searchBudget(result.work.allowance);
  SearchPath path;
  int looked = 0;
  int steps = 0;
  Foot foot = heldFoot(surface, state, motion.from);
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
  keep(body, state, hip, {foot.triangle, foot.feature, four(foot.point), four(surface.normal(foot))}, result);
  result.alongNormal = foot.feature == Feature::kPolygon;
  result.penetration_m =
      result.alongNormal ? distanceFrom(surface.triangle(foot.triangle), motion.to) : glm::length(state.ihip - hip);
  return true;
}

/// The common tick of all: alone, from a polygon that is kept from the last tick, or known. Of a HIP that is usable.
[[nodiscard, gnu::always_inline]] inline bool rub(std::span<const Body> bodies, ContactState& state, const Vec3& hip,
                                                  ContactResult& result, const KnownPolygons* known) noexcept {
  if (bodies.size() != 1 || state.feature != Feature::kPolygon) return false;
  const HoldingSurface& holding = state.holding[0];
  const Body& body = bodies[static_cast<std::size_t>(holding.body)];
  if (body.moving) return false;
  const HeldPolygon* polygon = &state.polygon;
  if (!polygon->is(*body.surface, holding.triangle)) {
    polygon = known != nullptr ? known->find(*body.surface, holding.triangle) : nullptr;
    if (polygon == nullptr) return false;
  }
  return goStraight(body, state, *polygon, hip, result, known, nullptr);
}

/// All that there can be to it otherwise, while one surface holds. Of a HIP that is usable.
[[nodiscard]] bool followBeside(std::span<const Body> bodies, ContactState& state, const Vec3& hip,
                                ContactResult& result) noexcept {
  const Body& body = bodies[static_cast<std::size_t>(state.holding[0].body)];
  const Surface& surface = *body.surface;
  if (body.moving || surface.anyCrossed() || surface.triangle(state.holding[0].triangle).zeroArea()) return false;
  // Where the whole way takes more than the allowance, or it is to be seen whether the IHIP is inside of another body.
  if (state.stride < 1 || state.unchecked) return false;
  Others others;
  if (bodies.size() > 1 && !findOthers(bodies, state, hip, others, result.work.allowance)) return false;
  if (state.feature == Feature::kPolygon) {
    const std::uint32_t triangle = state.holding[0].triangle;
    if (!state.polygon.is(surface, triangle)) state.polygon.become(surface, triangle);
    const Others* const beside = others.count > 0 ? &others : nullptr;
    if (goStraight(body, state, state.polygon, hip, result, nullptr, beside)) return true;
  }
  return searchBeside(body, others, state, hip, result);
}

[[gnu::noinline]] bool followOtherwise(std::span<const Body> bodies, ContactState& state, const Vec3& hip,
                                       ContactResult& result) noexcept {
  if (isUsable(hip) && followBeside(bodies, state, hip, result)) return true;
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
  const bool settled = !result.work.behind && !result.work.putOut && !state.unchecked;
  if (wasFree && settled && state.mode == ContactState::Mode::kFree) {
    lookForClearance(bodies, state, glm::distance(before, state.hip), result.work.allowance);
  }
  return false;
}

}  // namespace

bool followFast(std::span<const Body> bodies, ContactState& state, const Vec3& hip, ContactResult& result,
                const KnownPolygons* known) noexcept {
  if (state.mode != ContactState::Mode::kOneSurface) return followFreeOrSeveral(bodies, state, hip, result);
  if (isUsable(hip) && rub(bodies, state, hip, result, known)) [[likely]]
    return true;
  return followOtherwise(bodies, state, hip, result);
}

}  // namespace haptics

// The guarded neighborhood watch (surface_following.cpp) for the case that it has nothing to guard against.

#include "haptic_server/contact/follow_unblocked.h"

#include <algorithm>

#include "haptic_server/contact/contact_tick.h"
#include "haptic_server/contact/hip_following.h"
#include "haptic_server/contact/over_polygon.h"

namespace haptics {
namespace {

/// The bodies that NearBodies::gather() would find beside the held one.
struct Others {
  std::array<const Body*, kMaxNear - 1> body;
  std::size_t count = 0;

  [[nodiscard]] std::span<const Body* const> all() const noexcept { return std::span(body).first(count); }
};

/// False when a body moves, or when there are more than a tick looks at.
bool findOthers(std::span<const Body> bodies, const ContactState& state, Vec3 hip, Others& others) noexcept {
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
                                   const SearchPath& path) noexcept {
  if (!path.complete()) return false;
  double extent = body.extent_m;
  for (const Body* other : others.all()) extent = std::max(extent, other->extent_m);
  std::uint32_t triangle = state.holding[0].triangle;
  Vec3 lift = normal * (state.holding[0].side * (kSkin * extent));
  Vec3 from = body.frame.toWorld(state.local + lift);
  for (const SearchPath::Point& point : path) {
    if (point.triangle != triangle) {
      triangle = point.triangle;
      lift = body.surface->faceNormal(triangle) * (state.holding[0].side * (kSkin * extent));
    }
    const Vec3 to = body.frame.toWorld(point.place + lift);
    for (const Body* other : others.all()) {
      if (other->surface->firstCrossing(other->frame.toLocal(from), other->frame.toLocal(to))) return false;
    }
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
  std::uint8_t index;
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
  result.penetration_m = glm::length(ihip - hip);
  result.primitive = primitiveOf(*body.surface, {minimum.triangle, minimum.feature, minimum.index});
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
  return pathIsClear(body, others, state, body.surface->faceNormal(triangle), path);
}

/// On the polygon, or with nothing else in reach from polygon to polygon as followOverPolygons() does: the common case
/// of all. False when there is more to it.
[[nodiscard, gnu::always_inline]] inline bool goStraight(const Body& body, const Others& others, ContactState& state,
                                                         const Vec3& hip, ContactResult& result) noexcept {
  const Surface& surface = *body.surface;
  const HoldingSurface holding = state.holding[0];
  const Vec3 h = body.frame.toLocal(hip);
  const auto from = [&]() noexcept { return body.frame.toLocal(state.hip); };
  const int most = others.count > 0 ? 1 : kSearchBudget - 1;
  HoldingPolygon over;
  int looked = 0;
  if (!goOverPolygons(surface, holding.triangle, from, h, holding.side, most, over, looked)) [[unlikely]]
    return false;
  if (over.endsOutside) [[unlikely]]
    return false;
  if (others.count > 0) [[unlikely]] {
    if (!stayIsClear(body, others, state, vec3(over.foot), result.work)) return false;
  }
  result.work.triangles = looked;
  result.work.steps = 1;
  keep(body, state, hip, {over.triangle, Feature::kPolygon, 0, over.foot, over.unitNormal}, result);
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
  SearchPath path;
  int looked = 0;
  int steps = 0;
  Foot foot = heldFoot(surface, state, motion.from);
  for (double now = 0; now < 1;) {
    if (++steps == kMaxSteps) return false;
    const HipStep step = followHip(surface, motion, side, foot, now, steps, guarded ? &path : nullptr, looked);
    now = step.end;
    foot = step.found.foot;
    if (!step.found.converged || surface.onBoundary(foot)) return false;
    if (surface.isOutside(foot, motion.at(now), side)) return false;
  }
  if (guarded && !pathIsClear(body, others, state, surface.faceNormal(state.holding[0].triangle), path)) return false;
  result.work.triangles = looked;
  result.work.steps = steps;
  result.work.segments =
      static_cast<int>(others.count * (static_cast<std::size_t>(steps) + path.size()));  // each starts with one
  keep(body, state, hip, {foot.triangle, foot.feature, foot.index, four(foot.point), four(surface.normal(foot))},
       result);
  return true;
}

/// All that the tick reads and writes, asked for at once: with cold caches it then waits for memory once, not again and
/// again between waits for its own code.
void prefetch(const ContactState& state, const Body& body) noexcept {
  body.surface->prefetch(state.holding[0].triangle);
  for (const void* place : {static_cast<const void*>(&body.frame), static_cast<const void*>(&body.frame.origin),
                            static_cast<const void*>(&state.local)}) {
    __builtin_prefetch(place);
  }
}

}  // namespace

bool followUnblocked(std::span<const Body> bodies, ContactState& state, const Vec3& hip,
                     ContactResult& result) noexcept {
  if (state.mode != ContactState::Mode::kOneSurface || !isUsable(hip)) return false;
  const Body& body = bodies[static_cast<std::size_t>(state.holding[0].body)];
  const Surface& surface = *body.surface;
  prefetch(state, body);
  if (body.moving || surface.anyCrossed() || surface.triangle(state.holding[0].triangle).zeroArea()) [[unlikely]]
    return false;
  Others others;
  if (bodies.size() > 1) [[unlikely]] {
    if (!findOthers(bodies, state, hip, others)) return false;
  }
  if (state.feature == Feature::kPolygon && goStraight(body, others, state, hip, result)) [[likely]]
    return true;
  return searchBeside(body, others, state, hip, result);
}

}  // namespace haptics

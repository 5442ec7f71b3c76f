// The guarded neighborhood watch (surface_following.cpp) for the case that it has nothing to guard against.

#include "haptic_server/contact/follow_unblocked.h"

#include <algorithm>
#include <bit>

#include "haptic_server/contact/contact_tick.h"
#include "haptic_server/contact/hip_following.h"
#include "haptic_server/geometry/neighbours.h"

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

/// Where the neighborhood watch ends.
struct Minimum {
  Foot foot;
  Vec3 normal;
  int looked = 0;  // triangles
  int steps = 0;
};

/// A polygon and the prism over it, of h.
struct Over {
  std::uint32_t triangle;
  Prism prism;
};

/// The HIP has gone from one prism into the next: what followHip() makes of it when nothing else was in between, without
/// the time at which it went. False when there may be more to it.
[[nodiscard, gnu::always_inline]] inline bool hopOnce(const Surface& surface, int side, Vec3 from, Vec3 h,
                                                      Over& over) noexcept {
  const unsigned beyond = over.prism.beyond();
  const bool outside = (over.prism.height() >= 0) == (side > 0);
  if (!std::has_single_bit(beyond) || outside) return false;
  const int line = std::countr_zero(beyond);
  const int across = sameLineAcross(surface, over.triangle, line);
  if (across < 0) return false;
  over.triangle = surface.triangle(over.triangle).neighbour(line);
  over.prism = Prism(surface.triangle(over.triangle), all(h));
  // At both ends on the inner side of the other two lines: so it was when it came.
  const Prism before(surface.triangle(over.triangle), all(from));
  return over.prism.holds() && (before.beyond() & ~(1U << across)) == 0;
}

/// The HIP may have left the region of the primitive that held it. False when a search ends nowhere, or where the HIP is
/// not held. Out of line, as pathIsClear() is, to leave the registers to the tick that goes straight.
[[gnu::noinline]] bool searchOn(const Surface& surface, const ContactState& state, const HipMotion& motion,
                                SearchPath* path, Minimum& minimum) noexcept {
  const int side = state.holding[0].side;
  minimum.foot = heldFoot(surface, state, motion.from);
  for (double now = 0; now < 1;) {
    if (++minimum.steps == kMaxSteps) return false;
    const HipStep step = followHip(surface, motion, side, minimum.foot, now, path, minimum.looked);
    now = step.end;
    minimum.foot = step.found.foot;
    if (!step.found.converged || surface.onBoundary(minimum.foot)) return false;
    if (surface.isOutside(minimum.foot, motion.at(now), side)) return false;
  }
  minimum.normal = surface.normal(minimum.foot);
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

bool followUnblocked(std::span<const Body> bodies, ContactState& state, Vec3 hip, ContactResult& result) noexcept {
  if (state.mode != ContactState::Mode::kOneSurface) return false;
  const HoldingSurface holding = state.holding[0];
  const Body& body = bodies[static_cast<std::size_t>(holding.body)];
  const Surface& surface = *body.surface;
  const TriangleRecord& record = surface.triangle(holding.triangle);
  prefetch(state, body);
  if (body.moving || surface.anyCrossed() || record.zeroArea()) [[unlikely]]
    return false;
  Others others;
  if (bodies.size() > 1 && !findOthers(bodies, state, hip, others)) return false;

  const Vec3 h = body.frame.toLocal(hip);
  Over over{holding.triangle, Prism(record, all(h))};
  SearchPath path;
  const bool guarded = others.count > 0;
  Minimum minimum;
  Four foot;
  Four normal;
  const bool onPolygon = state.feature == Feature::kPolygon;
  const Vec3 from = body.frame.toLocal(state.hip);
  const bool stays = onPolygon && over.prism.holds();
  if (stays || (onPolygon && !guarded && hopOnce(surface, holding.side, from, h, over))) [[likely]] {
    const bool outside = (over.prism.height() >= 0) == (holding.side > 0);
    if (outside) [[unlikely]]
      return false;
    minimum.foot.triangle = over.triangle;
    minimum.looked = stays ? 1 : 2;
    minimum.steps = 1;
    foot = over.prism.foot(four(h));
    normal = over.prism.unitNormal();
    if (guarded) path.add(vec3(foot), over.triangle);
  } else {
    if (!searchOn(surface, state, {from, h}, guarded ? &path : nullptr, minimum)) return false;
    foot = four(minimum.foot.point);
    normal = four(minimum.normal);
  }
  if (guarded && !pathIsClear(body, others, state, surface.faceNormal(holding.triangle), path)) return false;

  const WideFrame frame(body.frame);
  state.holding[0].triangle = minimum.foot.triangle;
  state.feature = minimum.foot.feature;
  state.local = vec3(foot);
  state.ihip = vec3(frame.turn(foot) + frame.origin);
  state.hip = hip;
  result.touching = true;
  result.body = holding.body;
  result.ihip = state.ihip;
  result.normal = vec3(frame.turn(normal * all(holding.side)));
  result.penetration_m = glm::length(state.ihip - hip);
  result.primitive = primitiveOf(surface, minimum.foot);
  result.work.triangles = minimum.looked;
  result.work.segments =
      static_cast<int>(others.count * (static_cast<std::size_t>(minimum.steps) + path.size()));  // each starts with one
  result.work.steps = minimum.steps;
  return true;
}

}  // namespace haptics

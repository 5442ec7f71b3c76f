// The guarded neighborhood watch (surface_following.cpp) for the case that it has nothing to guard against.

#include "haptic_server/contact/follow_unblocked.h"

#include <algorithm>

#include "haptic_server/contact/contact_tick.h"

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
  if (bodies.size() == 1) return true;
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
  int looked = 1;  // triangles
};

/// The HIP has left the prism over the held triangle. False when the search ends nowhere, or where h is not held.
/// Out of line, as pathIsClear() is, to leave the registers to the tick that stays on its triangle.
[[gnu::noinline]] bool searchOn(const Surface& surface, const HoldingSurface& holding, Vec3 h, const Prism& prism,
                                SearchPath* path, Minimum& minimum) noexcept {
  const Foot start = closestOn(surface.triangle(holding.triangle), holding.triangle, h, prism);
  const SearchResult found = neighborhoodWatch(surface, start, h, path, minimum.looked);
  minimum.foot = found.foot;
  minimum.normal = surface.normal(found.foot);
  return found.converged && !surface.onBoundary(found.foot) && !surface.isOutside(found.foot, h, holding.side);
}

}  // namespace

bool followUnblocked(std::span<const Body> bodies, ContactState& state, Vec3 hip, ContactResult& result) noexcept {
  if (state.mode != ContactState::Mode::kOneSurface) return false;
  const HoldingSurface holding = state.holding[0];
  const Body& body = bodies[static_cast<std::size_t>(holding.body)];
  const Surface& surface = *body.surface;
  Others others;
  if (body.moving || surface.anyCrossed() || !findOthers(bodies, state, hip, others)) return false;

  const Vec3 h = body.frame.toLocal(hip);
  const TriangleRecord& record = surface.triangle(holding.triangle);
  const Prism prism(record, h);
  if (record.zeroArea() || !inOneStep(squaredLength(hip - state.hip), prism.squaredNormal())) return false;
  SearchPath path;
  const bool guarded = others.count > 0;
  const Vec3 normal = unitOrZero(prism.normal());
  Minimum minimum;
  if (prism.holds()) {
    const bool outside = (prism.height() >= 0) == (holding.side > 0);
    if (outside) return false;
    minimum.foot.triangle = holding.triangle;
    minimum.foot.point = prism.foot(h);
    minimum.normal = normal;
    if (guarded) path.add(minimum.foot);
  } else if (!searchOn(surface, holding, h, prism, guarded ? &path : nullptr, minimum)) {
    return false;
  }
  if (guarded && !pathIsClear(body, others, state, normal, path)) return false;

  state.holding[0].triangle = minimum.foot.triangle;
  state.local = minimum.foot.point;
  state.ihip = body.frame.toWorld(state.local);
  state.hip = hip;
  result.touching = true;
  result.body = holding.body;
  result.ihip = state.ihip;
  result.normal = body.frame.turn(minimum.normal * static_cast<double>(holding.side));
  result.penetration_m = glm::length(state.ihip - hip);
  result.primitive = primitiveOf(surface, minimum.foot);
  result.work.triangles = minimum.looked;
  result.work.segments = static_cast<int>(others.count * (1 + path.size()));  // the held body's own motion is one
  result.work.steps = 1;
  return true;
}

}  // namespace haptics

// The guarded neighborhood watch (surface_following.cpp) for the case that it has nothing to guard against.

#include "haptic_server/contact/follow_unblocked.h"

#include <algorithm>

#include "haptic_server/contact/contact_tick.h"
#include "haptic_server/contact/cross_lines.h"

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
};

/// Any search. False when it ends nowhere, or where h is not held. Out of line, as pathIsClear() is, to leave the
/// registers to the tick that goes straight.
[[gnu::noinline]] bool searchOn(const Surface& surface, const HoldingSurface& holding, Vec3 h, SearchPath* path,
                                Minimum& minimum) noexcept {
  minimum.looked = 0;
  const SearchResult found = neighborhoodWatch(surface, holding.triangle, h, path, minimum.looked);
  minimum.foot = found.foot;
  minimum.normal = surface.normal(found.foot);
  return found.converged && !surface.onBoundary(found.foot) && !surface.isOutside(found.foot, h, holding.side);
}

/// Axes and origin of a Frame, to turn and carry with its operations.
struct WideFrame {
  Four x, y, z, origin;

  explicit WideFrame(const Frame& f) noexcept : x(four(f.x)), y(four(f.y)), z(four(f.z)), origin(four(f.origin)) {}
  [[nodiscard]] Four turn(Four local) const noexcept {
    return x * allOf<0>(local) + y * allOf<1>(local) + z * allOf<2>(local);
  }
};

}  // namespace

bool followUnblocked(std::span<const Body> bodies, ContactState& state, Vec3 hip, ContactResult& result) noexcept {
  if (state.mode != ContactState::Mode::kOneSurface) return false;
  const HoldingSurface holding = state.holding[0];
  const Body& body = bodies[static_cast<std::size_t>(holding.body)];
  const Surface& surface = *body.surface;
  const TriangleRecord& record = surface.triangle(holding.triangle);
  if (body.moving || surface.anyCrossed() || record.zeroArea()) return false;
  Others others;
  if (bodies.size() > 1 && !findOthers(bodies, state, hip, others)) return false;

  const Vec3 h = body.frame.toLocal(hip);
  Walk walk{holding.triangle, Prism(record, all(h))};
  if (!inOneStep(squaredLength(hip - state.hip), walk.prism.squaredNormal())) return false;
  SearchPath path;
  const bool guarded = others.count > 0;
  Minimum minimum;
  Four foot;
  Four normal;
  if (crossLines(surface, h, guarded ? &path : nullptr, walk)) {
    const bool outside = (walk.prism.height() >= 0) == (holding.side > 0);
    if (outside) return false;
    minimum.foot.triangle = walk.triangle;
    minimum.looked = walk.looked;
    foot = walk.foot;
    normal = walk.prism.unitNormal();
  } else {
    path.clear();
    if (!searchOn(surface, holding, h, guarded ? &path : nullptr, minimum)) return false;
    foot = four(minimum.foot.point);
    normal = four(minimum.normal);
  }
  if (guarded && !pathIsClear(body, others, state, surface.faceNormal(holding.triangle), path)) return false;

  const WideFrame frame(body.frame);
  state.holding[0].triangle = minimum.foot.triangle;
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
  result.work.segments = static_cast<int>(others.count * (1 + path.size()));  // the held body's own motion is one
  result.work.steps = 1;
  return true;
}

}  // namespace haptics

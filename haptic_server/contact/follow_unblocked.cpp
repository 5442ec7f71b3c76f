// The guarded neighborhood watch (surface_following.cpp) for the case that it has nothing to guard against.

#include "haptic_server/contact/follow_unblocked.h"

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

/// ContactTick::pathIsClear() of a held body at rest that crosses itself nowhere.
bool pathIsClear(const Body& body, const Others& others, const ContactState& state, const SearchPath& path) noexcept {
  if (!path.complete()) return false;
  double extent = extentInReach(body);
  for (const Body* other : others.all()) extent = std::max(extent, extentInReach(*other));
  std::uint32_t triangle = state.holding[0].triangle;
  Vec3 lift = body.surface->faceNormal(triangle) * (state.holding[0].side * (kSkin * extent));
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

/// The local minimum near h and the normal there; false when it is none, or does not hold h any more.
bool findFoot(const Surface& surface, const HoldingSurface& holding, Vec3 h, const Prism& prism, SearchPath* path,
              int& looked, Foot& foot, Vec3& normal) noexcept {
  looked = 1;
  if (prism.holds()) {
    const bool outside = (prism.height() >= 0) == (holding.side > 0);
    if (outside) return false;
    foot.triangle = holding.triangle;
    foot.point = prism.foot(h);
    normal = unitOrZero(prism.normal());
    if (path != nullptr) path->add(foot);
    return true;
  }
  const Foot start = closestOn(surface.triangle(holding.triangle), holding.triangle, h, prism);
  const SearchResult found = neighborhoodWatch(surface, start, h, path, looked);
  foot = found.foot;
  if (!found.converged || surface.onBoundary(foot) || surface.isOutside(foot, h, holding.side)) return false;
  normal = surface.normal(foot);
  return true;
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
  const Prism prism(surface.triangle(holding.triangle), h);
  if (!inOneStep(squaredLength(hip - state.hip), prism.squaredNormal())) return false;
  SearchPath path;
  const bool guarded = others.count > 0;
  int looked = 0;
  Foot foot;
  Vec3 normal;
  if (!findFoot(surface, holding, h, prism, guarded ? &path : nullptr, looked, foot, normal)) return false;
  if (guarded && !pathIsClear(body, others, state, path)) return false;

  state.holding[0].triangle = foot.triangle;
  state.local = foot.point;
  state.ihip = body.frame.toWorld(state.local);
  state.hip = hip;
  result.touching = true;
  result.body = holding.body;
  result.ihip = state.ihip;
  result.normal = body.frame.turn(normal * static_cast<double>(holding.side));
  result.penetration_m = glm::length(state.ihip - hip);
  result.primitive = primitiveOf(surface, foot);
  result.work.triangles = looked;
  result.work.segments = static_cast<int>(others.count * (1 + path.size()));  // the held body's own motion is one
  result.work.steps = 1;
  return true;
}

}  // namespace haptics

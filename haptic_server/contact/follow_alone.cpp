#include "haptic_server/contact/follow_alone.h"

#include "haptic_server/contact/near_bodies.h"
#include "haptic_server/contact/neighborhood_watch.h"
#include "haptic_server/contact/step_length.h"

namespace haptics {
namespace {

/// NearBodies::gather() would find none but the held one.
bool nothingElseInReach(std::span<const Body> bodies, const ContactState& state, Vec3 hip) noexcept {
  if (bodies.size() == 1) return true;
  const double reach = reachOf(state, hip);
  const Body* held = &bodies[static_cast<std::size_t>(state.holding[0].body)];
  for (const Body& body : bodies) {
    if (body.moving) return false;
    if (&body != held && !body.leaving && squaredGap(body, hip, reach)) return false;
  }
  return true;
}

}  // namespace

bool followAlone(std::span<const Body> bodies, ContactState& state, Vec3 hip, ContactResult& result) noexcept {
  if (state.mode != ContactState::Mode::kOneSurface) return false;
  const HoldingSurface holding = state.holding[0];
  const Body& body = bodies[static_cast<std::size_t>(holding.body)];
  const Surface& surface = *body.surface;
  if (body.moving || surface.anyCrossed()) return false;

  const Vec3 h = body.frame.toLocal(hip);
  const Prism prism(surface.triangle(holding.triangle), h);
  if (!inOneStep(squaredLength(hip - state.hip), prism.squaredNormal())) return false;
  int looked = 1;
  Foot foot;
  Vec3 normal;
  if (prism.holds()) {
    const bool outside = (prism.height() >= 0) == (holding.side > 0);
    if (outside) return false;
    foot.triangle = holding.triangle;
    foot.point = prism.foot(h);
    normal = unitOrZero(prism.normal());
  } else {
    looked = 0;
    const SearchResult found = neighborhoodWatch(surface, holding.triangle, h, nullptr, looked);
    foot = found.foot;
    if (!found.converged || surface.onBoundary(foot) || surface.isOutside(foot, h, holding.side)) return false;
    normal = surface.normal(foot);
  }
  if (!nothingElseInReach(bodies, state, hip)) return false;

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
  result.work.steps = 1;
  return true;
}

}  // namespace haptics

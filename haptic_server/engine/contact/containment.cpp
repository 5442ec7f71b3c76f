#include "haptic_server/engine/contact/containment.h"

#include "haptic_server/engine/contact/depenetration.h"
#include "haptic_server/engine/contact/nearest_foot.h"
#include "haptic_server/engine/geometry/enclosure.h"

namespace haptics {
namespace {

/// Is a place of the IHIP (body frame) where its path led? Where the solver finds no way out of bodies that move they may pass
/// over the IHIP, a thin one altogether. The path of one that is held is tested a path offset above it.
[[nodiscard]] bool isTested(const TickContext& tick, const NearBodies::Near& near, Vec3 to) noexcept {
  if (!near.surface->closed()) return near.from == to;
  return squaredLength(to - near.from) <= 4 * tick.pathOffset * tick.pathOffset;
}

}  // namespace

/// The path of the IHIP keeps it outside of bodies at rest. Moving ones can close in on it until the solver finds no
/// way out of theirs, a mesh that passes through itself has surface inside of itself, and an adoption puts bodies
/// anywhere.
bool mayBeInside(const TickContext& tick) noexcept {
  if (!tick.corrections.containment || !tick.corrections.objectFrameSegments) return false;
  if (tick.state.reprojected || tick.work.notConverged || tick.work.droppedBodies > 0) return true;
  const bool alone = tick.state.mode == ContactState::Mode::kOneSurface && tick.near.count() == 1;
  for (int i = 0; i < tick.near.count(); ++i) {
    const Body& body = tick.body(tick.near[i].body);
    if ((body.moving && !alone) || body.surface->anySelfIntersecting()) return true;
  }
  return false;
}

int enclosingBody(TickContext& tick) noexcept {
  const ContactState& state = tick.state;
  Allowance& allowance = tick.work.allowance;
  tick.near.setTime(tick.bodies, 1);
  allowance.spend(Allowance::kSphere * static_cast<std::int64_t>(tick.bodies.size()));
  const int onSurface = state.mode == ContactState::Mode::kOneSurface ? tick.held().body : -1;
  for (int b = 0; b < static_cast<int>(tick.bodies.size()) && !allowance.isSpent(); ++b) {
    const Body& body = tick.body(b);
    if (body.pendingRemoval || !body.surface->closed() || !withinSphere(body, state.ihip)) continue;
    Vec3 at = body.frame.toLocal(state.ihip);
    if (b == onSurface) {
      if (!body.surface->anySelfIntersecting()) continue;
      at = state.local + body.surface->normal(tick.foot) * tick.startOffset;
    }
    ++tick.work.segments;
    if (windingNumber(*body.surface, at, allowance) <= 0) continue;
    const ClosestPoint foot = nearestFoot(*body.surface, at, allowance);
    if (allowance.isSpent()) return -1;
    if (foot.squaredDistance > kDepthTolerance * kDepthTolerance * tick.skin * tick.skin) return b;
  }
  for (int i = 0; i < tick.near.count() && !allowance.isSpent(); ++i) {
    const NearBodies::Near& near = tick.near[i];
    if (near.pendingRemoval || near.body == onSurface) continue;
    const Vec3 to = near.frame.toLocal(state.ihip);
    if (isTested(tick, near, to)) continue;
    if (tick.near.crossing(near, to, tick.work)) return near.body;
  }
  return -1;
}

std::optional<Vec3> placeOutside(TickContext& tick) noexcept {
  const Vec3 toIhip = tick.state.ihip - tick.hip;
  const double depth = glm::length(toIhip);
  const Vec3 outward = depth > 0 ? toIhip / depth : Vec3(0);
  const auto out = findDepenetration(tick.bodies, tick.near, tick.state.ihip, outward, tick.skin, tick.work);
  if (!out) return out;
  tick.work.depenetrated = true;
  tick.setFree(*out);
  tick.near.gather(tick.bodies, tick.state, tick.hip, tick.work);
  tick.near.setTime(tick.bodies, 1);
  tick.near.moveAll(tick.near.inEachFrame(*out), 1);
  return out;
}

}  // namespace haptics

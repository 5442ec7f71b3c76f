#include "haptic_server/servo/cache_warmer.h"

#include "haptic_server/engine/contact/neighborhood_watch.h"

namespace haptics {

void CacheWarmer::operator()(const ServoScene& scene, const HapticState& state) noexcept {
  if (&scene != scene_) {  // which still was there while this one was made
    cache_.clear();
    scene_ = &scene;
    isCopy_ = false;
  }
  const bool affordable = left_.left() >= state.allowance.left() / 4 * 3;
  if (!state.supervision.attached || !affordable || state.features.tool || state.reshaped.count > 0) {
    isCopy_ = false;  // of what the state goes on to
    return;
  }
  const bool isComplete = rehearse(scene, state);
  Allowance looks(state.allowance.left() / 16);
  prefetchNeighbours(state.contact, looks);
  prefetchNeighbours(rehearsal_.contact, looks);
  if (isComplete) static_cast<void>(rehearse(scene, state));
}

/// Triangles from each of the neighbours: what a tick needs that hops over one or two. Around a vertex of thousands nobody
/// is to wait for all of them.
constexpr int kMaxLookedAt = 32;

/// At the polygons two rings around the contact. Those of the first are worked out, and searched from back to the IHIP, as
/// by a tick that crosses a line.
void CacheWarmer::prefetchNeighbours(const ContactState& contact, Allowance& looks) noexcept {
  for (const ContactSurface& held : contact.surfaces()) {
    const Body& body = rehearsal_.bodies[static_cast<std::size_t>(held.body)];
    const CollisionMesh& surface = *body.surface;
    const Vec3 ihip = body.frame.toLocal(contact.ihip);
    const TriangleRecord& own = surface.triangle(held.triangle);
    for (int k = 0; k < 3; ++k) {
      if (own.neighbour(k) != kNoTriangle) surface.prefetch(own.neighbour(k));
    }
    cache_.insert(surface, held.triangle);
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t across = own.neighbour(k);
      if (across == kNoTriangle) continue;
      cache_.insert(surface, across);
      const TriangleRecord& next = surface.triangle(across);
      for (int j = 0; j < 3; ++j) {
        if (next.neighbour(j) != kNoTriangle) surface.prefetch(next.neighbour(j));
      }
      SearchRun run{.budget = kMaxLookedAt};
      static_cast<void>(neighborhoodWatch(surface, across, ihip, run));
      looks.spend(Allowance::kNearTriangle * run.looked);
      if (looks.isSpent()) return;
    }
  }
}

/// Units (Allowance) of copying a body.
constexpr std::int64_t kCopyBody = 64;

bool CacheWarmer::rehearse(const ServoScene& scene, const HapticState& state) noexcept {
  Allowance allowance(state.allowance.left() / 8);  // of two
  if (!isCopy_) allowance.spend(kCopyBody * static_cast<std::int64_t>(state.objects.count));
  if (allowance.isSpent()) return false;
  if (isCopy_) {
    rehearsal_.copyForRehearsal(state);
  } else {
    rehearsal_.copyInUse(state);
  }
  rehearsal_.allowance = allowance;
  isCopy_ = !state.features.beingMoved;
  const Vec3 next = state.estimate.measured + state.estimate.velocity.velocity() * config_.period_s;
  ForceResult result;
  computeForce(scene, rehearsal_, config_, {0, 0, {next, DeviceState::kReady}}, result, &cache_);
  return !result.contact.work.allowance.isSpent();
}

}  // namespace haptics

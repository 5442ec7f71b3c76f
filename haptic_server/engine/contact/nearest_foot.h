#pragma once

#include "haptic_server/engine/contact/neighborhood_watch.h"

namespace haptics {

/// The closest point of a whole surface to `local` (its frame, metres). A query takes no more than some 100 us and half
/// of the allowance; where that ends it, the result is a local minimum. Of no triangle, and the allowance spent, where
/// that does not last for one.
[[nodiscard]] inline ClosestPoint nearestFoot(const CollisionMesh& surface, Vec3 local, Allowance& allowance) noexcept {
  constexpr int kQueryBudget = 4096;
  Allowance half(allowance.left() / 2);
  const std::int64_t before = half.left();
  int spent = 0;
  const ClosestPoint best = surface.closestFoot(local, kQueryBudget, spent, half);
  allowance.spend(before - half.left());
  if (best.triangle == kNoTriangle) {
    allowance.spend(allowance.left() + 1);
    return best;
  }
  SearchRun run{.budget = searchBudget(allowance)};
  const ClosestPoint foot = neighborhoodWatch(surface, best.triangle, local, run).foot;
  allowance.spend(Allowance::kNearTriangle * run.looked);
  return foot;
}

}  // namespace haptics

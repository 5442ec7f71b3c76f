#include "haptic_server/engine/surface/nearest_point.h"

namespace haptics {

ClosestPoint nearestPoint(const CollisionMesh& surface, Vec3 h, double reach_m, std::uint32_t hint,
                          Allowance& allowance) noexcept {
  ClosestPoint best;
  best.squaredDistance = reach_m * reach_m;
  int left = kNearestBudget;
  const auto look = [&](std::uint32_t t) noexcept {
    const ClosestPoint foot = closestOn(surface.triangle(t), t, h);
    if (foot.squaredDistance < best.squaredDistance) best = foot;
    --left;
    allowance.spend(Allowance::kNearTriangle);
  };
  if (hint != kNoTriangle) look(hint);
  surface.hierarchy().visitNear(
      h, allowance,
      [&](std::uint32_t begin, std::uint32_t end) noexcept {
        for (std::uint32_t t = begin; t < end && left > 0; ++t) look(t);
        return left > 0 ? best.squaredDistance : -1.0;
      },
      best.squaredDistance);
  return best;
}

}  // namespace haptics

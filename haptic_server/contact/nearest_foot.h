#pragma once

#include "haptic_server/contact/neighborhood_watch.h"

namespace haptics {

/// The closest point of a surface to `local` (its frame, metres), wherever on it. Looks at so many triangles that a query
/// takes no more than some 100 us; had that not been enough, from the best of them to a local minimum.
[[nodiscard]] inline Foot nearestFoot(const Surface& surface, Vec3 local) noexcept {
  constexpr int kQueryBudget = 4096;
  int spent = 0;
  const Foot foot = surface.closestFoot(local, kQueryBudget, spent);
  spent = 0;
  return neighborhoodWatch(surface, foot.triangle, local, nullptr, spent).foot;
}

}  // namespace haptics

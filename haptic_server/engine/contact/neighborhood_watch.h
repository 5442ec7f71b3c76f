#pragma once

#include <algorithm>
#include <cstdint>

#include "haptic_server/engine/contact/corrections.h"
#include "haptic_server/engine/contact/search_path.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// Triangles that a tick may have looked at when its next search ends, after `looked`: a search takes half of the
/// allowance at most.
[[nodiscard]] inline int searchBudget(const Allowance& allowance, int looked = 0) noexcept {
  const std::int64_t affordable = looked + allowance.left() / (2 * Allowance::kNearTriangle);
  return static_cast<int>(std::clamp<std::int64_t>(affordable, 1, kSearchBudget));
}

/// The neighborhood watch of the paper: descends from triangle `start` to a local minimum of the distance to h (body
/// frame, metres).
[[nodiscard]] SearchResult neighborhoodWatch(const CollisionMesh& surface, std::uint32_t start, Vec3 h,
                                             SearchRun& run) noexcept;
/// The same with some of its corrections switched off.
[[nodiscard]] SearchResult ablatedWatch(const CollisionMesh& surface, std::uint32_t start, Vec3 h, SearchRun& run,
                                        const Corrections& corrections) noexcept;

}  // namespace haptics

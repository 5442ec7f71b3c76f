#pragma once

#include <algorithm>
#include <cstdint>

#include "haptic_server/engine/contact/corrections.h"
#include "haptic_server/engine/contact/search_path.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// Triangles that the searches of one tick may look at, unless its allowance is for less. It bounds the tick; a fan of
/// more is looked at over several ticks. In 36 million ticks of a random walk over a scan of 870,000 triangles the
/// longest slide to another minimum took 2,165 triangles, in a quarter of a millisecond. Smaller leaves such slides to
/// the next tick, larger makes the longest tick longer.
inline constexpr int kSearchBudget = 3200;

/// Triangles that a tick may have looked at when its next search ends, after `looked`: a search takes half of the
/// allowance at most.
[[nodiscard]] inline int searchBudget(const Allowance& allowance, int looked = 0) noexcept {
  const std::int64_t affordable = looked + allowance.left() / (2 * Allowance::kNearTriangle);
  return static_cast<int>(std::clamp<std::int64_t>(affordable, 1, kSearchBudget));
}

/// The neighborhood watch of the paper: descends from triangle `start` to a local minimum of the distance to h (body
/// frame, metres). Adds the triangles looked at to `spent`, and ends when that is `budget`; `path` may be null.
[[nodiscard]] SearchResult neighborhoodWatch(const CollisionMesh& surface, std::uint32_t start, Vec3 h,
                                             SearchPath* path, int& spent, int budget = kSearchBudget) noexcept;
/// The same with some of its corrections switched off.
[[nodiscard]] SearchResult ablatedWatch(const CollisionMesh& surface, std::uint32_t start, Vec3 h, SearchPath* path,
                                        int& spent, int budget, const Corrections& corrections) noexcept;

}  // namespace haptics

#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "haptic_server/contact/corrections.h"
#include "haptic_server/geometry/collision_mesh.h"

namespace haptics {

/// Triangles that the searches of one tick may look at, unless its allowance is for less. It bounds the tick; a fan of
/// more is looked at over several ticks.
/// Until it is found the IHIP is behind: where a minimum ends in the middle of a scan of 870,000 triangles, the slide to
/// the next one, of up to 110 mm, took up to 2,165, in a quarter of a millisecond, in 36 million ticks of a random walk.
/// Smaller leaves such slides to the next tick, larger makes the longest tick longer.
inline constexpr int kSearchBudget = 3200;

/// Triangles that a search may have looked at in a tick when it ends, after so many: it takes half of the allowance at
/// most.
[[nodiscard]] inline int searchBudget(const Allowance& allowance, int looked = 0) noexcept {
  const std::int64_t affordable = looked + allowance.left() / (2 * Allowance::kNearTriangle);
  return static_cast<int>(std::clamp<std::int64_t>(affordable, 1, kSearchBudget));
}

/// The continuous polyline on the surface along which a search moved: point i lies in triangle i, and so does the way
/// to it.
class SearchPath {
 public:
  /// Points kept. Longer paths are left to the solver, which walks them plane by plane.
  static constexpr std::size_t kCapacity = 48;
  struct Point {
    Vec3 place;  // body frame, metres
    std::uint32_t triangle;
  };

  void add(Vec3 place, std::uint32_t triangle) noexcept {
    if (count_ < kCapacity) points_[count_] = {place, triangle};
    ++count_;
  }
  void keepFirst(std::size_t count) noexcept { count_ = count; }
  [[nodiscard]] bool complete() const noexcept { return count_ <= kCapacity; }
  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  [[nodiscard]] auto begin() const noexcept { return points_.begin(); }
  [[nodiscard]] auto end() const noexcept { return points_.begin() + static_cast<std::ptrdiff_t>(count_); }

 private:
  std::array<Point, kCapacity> points_;
  std::size_t count_ = 0;
};

struct SearchResult {
  ClosestPoint foot;
  /// No neighbour is closer. False when the budget ran out: the foot is the best so far, or, inside of a fan, the place
  /// to go on from; the sign of the penetration is then not known.
  bool converged = true;
};

/// Descends from `start`, the closest point to h (body frame, metres) of some triangle, to a local minimum of the
/// distance. Adds the further triangles looked at to `spent`, and ends when that is `budget`; `path` may be null.
[[nodiscard]] SearchResult neighborhoodWatch(const CollisionMesh& surface, const ClosestPoint& start, Vec3 h,
                                             SearchPath* path, int& spent, int budget = kSearchBudget,
                                             const Corrections& corrections = kAllCorrections) noexcept;

/// The same from triangle `start`, which counts as looked at.
[[nodiscard]] SearchResult neighborhoodWatch(const CollisionMesh& surface, std::uint32_t start, Vec3 h,
                                             SearchPath* path, int& spent, int budget = kSearchBudget,
                                             const Corrections& corrections = kAllCorrections) noexcept;

}  // namespace haptics

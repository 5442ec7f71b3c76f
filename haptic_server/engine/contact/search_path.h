#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "haptic_server/engine/geometry/closest_point.h"

namespace haptics {

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

/// Triangles that the searches of one tick may look at, unless its allowance is for less. It bounds the tick; a fan of
/// more is looked at over several ticks. In 36 million ticks of a random walk over a scan of 870,000 triangles the
/// longest slide to another minimum took 2,165 triangles, in a quarter of a millisecond. Smaller leaves such slides to
/// the next tick, larger makes the longest tick longer.
inline constexpr int kSearchBudget = 3200;

/// What searches may look at, and what they leave beside the result.
struct SearchRun {
  int budget = kSearchBudget;  ///< A search ends once so many triangles were looked at, of all searches of the run.
  int looked = 0;
  SearchPath* path = nullptr;  ///< Where they went is added here; null: not kept.

  void add(Vec3 place, std::uint32_t triangle) const noexcept {
    if (path != nullptr) path->add(place, triangle);
  }
};

struct SearchResult {
  ClosestPoint foot;
  /// No neighbour is closer. False when the budget ran out: the foot is the best so far, or, inside of a fan, the place
  /// to go on from; the sign of the penetration is then not known.
  bool converged = true;
};

}  // namespace haptics

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

struct SearchResult {
  ClosestPoint foot;
  /// No neighbour is closer. False when the budget ran out: the foot is the best so far, or, inside of a fan, the place
  /// to go on from; the sign of the penetration is then not known.
  bool converged = true;
};

}  // namespace haptics

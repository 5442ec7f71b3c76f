#pragma once

#include <cstddef>
#include <cstdint>

#include "common/interruption/interruption.h"

namespace haptics {

/// Work that a part of an import may do, in units of some 3 ns. Counted, not timed: the report on a file is the same on
/// every machine.
class Work {
 public:
  explicit constexpr Work(std::int64_t units) noexcept : left_(units) {}
  /// Limit for a mesh of so many triangles or edges, `each` units for each of them.
  constexpr Work(std::size_t count, std::int64_t each) noexcept
      : left_(kForAnyMesh + each * static_cast<std::int64_t>(count)) {}

  /// Returns whether there was as much left. An interruption point in each few milliseconds of work.
  bool spend(std::size_t units) {
    const std::int64_t before = left_;
    left_ -= static_cast<std::int64_t>(units);
    if ((before ^ left_) >> kInterruptible != 0) interruptionPoint();
    return left_ >= 0;
  }
  [[nodiscard]] constexpr bool isOver() const noexcept { return left_ < 0; }
  [[nodiscard]] constexpr std::int64_t left() const noexcept { return left_; }

 private:
  /// Some 10 ms. Larger searches more of small meshes whose triangles all meet, and takes as much longer.
  static constexpr std::int64_t kForAnyMesh = std::int64_t{1} << 21;

  static constexpr int kInterruptible = 20;  // bits of units

  std::int64_t left_;
};

}  // namespace haptics

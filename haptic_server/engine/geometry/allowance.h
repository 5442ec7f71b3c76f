#pragma once

#include <cstdint>
#include <limits>

namespace haptics {

/// What the queries of a tick may still cost together, in units of work: two to five instructions (x86-64) each, as
/// haptic_eval worst counts them. A query that runs out of it ends at once, and its answer means nothing: whoever asks looks at
/// isSpent() before the answer is acted upon.
class Allowance {
 public:
  // Units.
  static constexpr std::int64_t kQuery = 192;        ///< To begin a query of a hierarchy.
  static constexpr std::int64_t kSphere = 6;         ///< To see whether a place is in the sphere about a body.
  static constexpr std::int64_t kPlace = 16;         ///< To take a place into a body's frame.
  static constexpr std::int64_t kNode = 80;          ///< A node's eight boxes.
  static constexpr std::int64_t kTriangle = 64;      ///< A triangle against a segment.
  static constexpr std::int64_t kNearTriangle = 96;  ///< The closest point of a triangle.
  static constexpr std::int64_t kPlanes = 1'500;     ///< A round of the constraint solver, queries apart.

  /// Endless.
  Allowance() = default;
  explicit constexpr Allowance(std::int64_t units) noexcept : left_(units) {}

  constexpr void spend(std::int64_t units) noexcept { left_ -= units; }
  [[nodiscard]] constexpr bool isSpent() const noexcept { return left_ < 0; }
  [[nodiscard]] constexpr std::int64_t left() const noexcept { return left_; }

 private:
  std::int64_t left_ = std::numeric_limits<std::int64_t>::max();
};

}  // namespace haptics

#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace haptics {

using Vector6 = std::array<double, 6>;

/// All x of which dot(normal, x) >= offset. The normal has any length but 0.
struct HalfSpace6 {
  Vector6 normal;
  double offset;
};

struct LeastDistance {
  bool exists = true;  ///< Some x is in all of them; else the other two mean nothing.
  Vector6 x{};
  int tightCount = 0;
  std::array<std::uint32_t, 7> tight{};  ///< Those on whose boundary x is held.
  std::array<double, 7> multiplier{};    ///< Of their normals, which add up to x with it; none is negative.
};

/// Most half-spaces of one call; more are left out.
inline constexpr std::size_t kMaxHalfSpaces = 1024;

/// The point nearest to the origin that is in all half-spaces: least distance programming by non-negative least squares
/// (Lawson & Hanson, Solving Least Squares Problems, 1974, chapter 23). Neither allocates nor depends on what it was
/// called with before. O(half-spaces) times the number of those that come to hold, which is hardly more than ten.
[[nodiscard]] LeastDistance leastDistance(std::span<const HalfSpace6> halfSpaces) noexcept;

}  // namespace haptics

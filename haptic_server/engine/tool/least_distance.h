#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace haptics {

/// Of a tool's freedoms six are those of its pose, the seventh is how far its jaws are open.
inline constexpr std::size_t kMaxFreedoms = 7;
using Freedoms = std::array<double, kMaxFreedoms>;

/// All x of which dot(normal, x) >= offset. The normal has any length; one of 0 asks for nothing.
struct HalfSpace {
  Freedoms normal;
  double offset;
};

struct LeastDistance {
  bool exists = true;  ///< Some x is in all of them; else the other two mean nothing.
  Freedoms x{};
  int tightCount = 0;
  std::array<std::uint32_t, kMaxFreedoms + 1> tight{};  ///< Those on whose boundary x is held.
  /// Of their normals, which add up to x with it; none is negative.
  std::array<double, kMaxFreedoms + 1> multiplier{};
};

/// Most half-spaces of one call; more are left out.
inline constexpr std::size_t kMaxHalfSpaces = 1024;

/// The point nearest to the origin that is in all half-spaces: least distance programming by non-negative least squares
/// (Lawson & Hanson, Solving Least Squares Problems, 1974, chapter 23). Neither allocates nor depends on what it was
/// called with before. O(half-spaces) times the number of those that come to hold, which is hardly more than ten.
/// @tparam kFreedoms  6 or 7: of x and the normals, the others are not read and stay 0.
template <std::size_t kFreedoms = 6>
[[nodiscard]] LeastDistance leastDistance(std::span<const HalfSpace> halfSpaces) noexcept;

}  // namespace haptics

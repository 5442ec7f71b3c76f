#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "common/maths/vec.h"

namespace haptics {

/// The numbers 0 to count - 1 in the order in which their points lie along a Morton curve: near each other in space, near
/// each other in the order. To a grid of 2^21 cells along the longest side. pointOf(i) gives a Vec3.
template <class PointOf>
[[nodiscard]] std::vector<std::uint32_t> mortonOrder(std::uint32_t count, PointOf pointOf) {
  constexpr int kBits = 21;
  const auto spread = [](std::uint64_t x) {
    x = (x | x << 32) & 0x1F00000000FFFF;
    x = (x | x << 16) & 0x1F0000FF0000FF;
    x = (x | x << 8) & 0x100F00F00F00F00F;
    x = (x | x << 4) & 0x10C30C30C30C30C3;
    return (x | x << 2) & 0x1249249249249249;
  };
  Vec3 low(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (std::uint32_t i = 0; i < count; ++i) {
    low = glm::min(low, pointOf(i));
    high = glm::max(high, pointOf(i));
  }
  const Vec3 size = high - low;
  const double longest = std::max({size.x, size.y, size.z});
  const double perMetre = longest > 0 ? ((1 << kBits) - 1) / longest : 0;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3 at = (pointOf(i) - low) * perMetre;
    std::uint64_t key = 0;
    for (int d = 0; d < 3; ++d) key |= spread(static_cast<std::uint64_t>(at[d])) << d;
    keys[i] = {key, i};
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order(count);
  std::transform(keys.begin(), keys.end(), order.begin(), [](const auto& key) { return key.second; });
  return order;
}

}  // namespace haptics

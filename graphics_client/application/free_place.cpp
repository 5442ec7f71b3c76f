#include "graphics_client/application/free_place.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptics {
namespace {

/// Directions in which places are looked for, and steps on the way out.
constexpr int kDirections = 24, kSteps = 60;

bool meet(const FloorBox& a, const FloorBox& b) {
  return a.low.x < b.high.x && b.low.x < a.high.x && a.low.y < b.high.y && b.low.y < a.high.y;
}

}  // namespace

glm::dvec2 freePlace(std::span<const FloorBox> others, glm::dvec2 size_m, double gap_m) {
  if (others.empty()) return glm::dvec2(0);
  FloorBox all = others.front();
  for (const FloorBox& other : others) {
    all.low = glm::min(all.low, other.low);
    all.high = glm::max(all.high, other.high);
  }
  const glm::dvec2 middle = (all.low + all.high) / 2.0, half = size_m / 2.0 + gap_m;
  const double farthest_m = glm::length(all.high - all.low) / 2 + glm::length(half);
  for (int step = 0; step <= kSteps; ++step) {
    for (int i = 0; i < kDirections; ++i) {
      const double angle = 2 * std::numbers::pi * i / kDirections, way_m = farthest_m * step / kSteps;
      const glm::dvec2 at = middle + way_m * glm::dvec2(std::cos(angle), std::sin(angle));
      const FloorBox box{at - half, at + half};
      if (std::ranges::none_of(others, [&](const FloorBox& other) { return meet(box, other); })) return at;
    }
  }
  return {all.high.x + half.x, middle.y};
}

}  // namespace haptics

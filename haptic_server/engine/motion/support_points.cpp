#include "haptic_server/engine/motion/support_points.h"

#include <algorithm>
#include <cstdint>
#include <numbers>

#include "common/interruption/interruption.h"
#include "common/maths/elementary.h"

namespace haptics {
namespace {

/// The k-th of kSupportDirections points of a Fibonacci spiral on the unit sphere.
[[nodiscard]] Vec3 direction(int k) {
  const double z = 1 - (2 * k + 1.0) / kSupportDirections;
  const double angle = 2 * std::numbers::pi * (k + 0.5) * (std::numbers::phi - 1);
  const double radius = std::sqrt(1 - z * z);
  const auto [sine, cosine] = elementary::sineCosine(angle);
  return {radius * cosine, radius * sine, z};
}

}  // namespace

std::vector<Vec3> supportPoints(std::span<const Vec3f> vertices) {
  std::vector<std::size_t> farthest;
  for (int k = 0; k < kSupportDirections && !vertices.empty(); ++k) {
    interruptionPoint();
    const Vec3 out = direction(k);
    std::size_t best = 0;
    double reach = glm::dot(out, Vec3(vertices[0]));
    for (std::size_t i = 1; i < vertices.size(); ++i) {
      const double here = glm::dot(out, Vec3(vertices[i]));
      if (here > reach) {
        reach = here;
        best = i;
      }
    }
    farthest.push_back(best);
  }
  std::ranges::sort(farthest);
  farthest.erase(std::unique(farthest.begin(), farthest.end()), farthest.end());

  std::vector<Vec3> points;
  points.reserve(farthest.size());
  for (const std::size_t i : farthest) points.emplace_back(vertices[i]);
  return points;
}

}  // namespace haptics

#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "haptic_server/device/exploration_plan.h"
#include "haptic_server/device/stroke_choice.h"

namespace haptics::test {

/// A solid as its signed distance (metres, negative inside), in a box; felt as a spring along the distance's gradient.
struct Solid {
  std::uint64_t id = 0;
  std::function<double(Vec3)> distance;
  Vec3 low{0}, high{0};

  [[nodiscard]] Vec3 normal(Vec3 p) const {
    constexpr double kProbe = 1e-6;
    const auto slope = [&](Vec3 axis) { return distance(p + kProbe * axis) - distance(p - kProbe * axis); };
    return glm::normalize(Vec3(slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})));
  }
  /// Marches down along the distance.
  [[nodiscard]] std::optional<TopPoint> top(double x, double y) const {
    constexpr double kOnSurface = 1e-7;
    for (Vec3 p(x, y, high.z + 1e-3); p.z > low.z;) {
      const double d = distance(p);
      if (d < kOnSurface) return TopPoint{p, normal(p)};
      p.z -= d;
    }
    return std::nullopt;
  }
};

inline Solid sphere(std::uint64_t id, Vec3 centre, double radius) {
  return {id, [=](Vec3 p) { return glm::distance(p, centre) - radius; }, centre - radius, centre + radius};
}

inline Solid box(std::uint64_t id, Vec3 centre, Vec3 half) {
  return {id,
          [=](Vec3 p) {
            const Vec3 q = glm::abs(p - centre) - half;
            return glm::length(glm::max(q, Vec3(0))) + std::min(std::max({q.x, q.y, q.z}), 0.0);
          },
          centre - half, centre + half};
}

/// Lying flat.
inline Solid torus(std::uint64_t id, Vec3 centre, double majorRadius, double minorRadius) {
  const Vec3 half(majorRadius + minorRadius, majorRadius + minorRadius, minorRadius);
  return {id,
          [=](Vec3 p) {
            const Vec3 q = p - centre;
            return std::hypot(std::hypot(q.x, q.y) - majorRadius, q.z) - minorRadius;
          },
          centre - half, centre + half};
}

/// Everything below z = height.
inline Solid ground(std::uint64_t id, double height) {
  return {id, [=](Vec3 p) { return p.z - height; }, {-0.05, -0.05, height - 0.01}, {0.05, 0.05, height}};
}

struct AnalyticScene {
  std::vector<Solid> solids;
  double stiffness_N_per_m = 800;

  [[nodiscard]] Vec3 force(Vec3 hip) const {
    Vec3 sum(0);
    for (const Solid& solid : solids) {
      const double d = solid.distance(hip);
      if (d < 0) sum += -stiffness_N_per_m * d * solid.normal(hip);
    }
    return sum;
  }

  [[nodiscard]] ExplorationPlan plan() const {
    ExplorationPlan plan{{}, -std::numeric_limits<double>::infinity()};
    for (const Solid& solid : solids) {
      const auto view = [&solid](double x, double y) { return solid.top(x, y); };
      plan.strokes.push_back({solid.id, chooseStroke(view, solid.low, solid.high)});
      plan.clearHeight_m = std::max(plan.clearHeight_m, solid.high.z + 0.02);
    }
    return plan;
  }
};

}  // namespace haptics::test

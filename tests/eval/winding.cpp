#include "tests/eval/winding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "tests/eval/closest_on_triangle.h"

namespace haptics::eval {

WindingMesh::WindingMesh(std::span<const Vec3f> vertices, std::span<const TriangleIndices> triangles)
    : low_(std::numeric_limits<double>::infinity()), high_(-low_) {
  for (const TriangleIndices& t : triangles) {
    triangles_.push_back({Vec3(vertices[t[0]]), Vec3(vertices[t[1]]), Vec3(vertices[t[2]])});
    for (const Vec3 corner : triangles_.back()) {
      low_ = glm::min(low_, corner);
      high_ = glm::max(high_, corner);
    }
  }
}

double WindingMesh::windingNumber(Vec3 point) const {
  double angle = 0;
  for (const auto& t : triangles_) {
    const Vec3 a = t[0] - point;
    const Vec3 b = t[1] - point;
    const Vec3 c = t[2] - point;
    const double la = glm::length(a);
    const double lb = glm::length(b);
    const double lc = glm::length(c);
    const double volume = glm::dot(a, glm::cross(b, c));
    angle += 2 * std::atan2(volume, la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return angle / (4 * std::numbers::pi);
}

double WindingMesh::distanceTo(Vec3 point) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& t : triangles_) nearest = std::min(nearest, glm::distance(closestOnTriangle(point, t), point));
  return nearest;
}

double WindingMesh::depthInside(Vec3 point) const {
  constexpr double kHalf = 0.5;
  if (glm::any(glm::lessThan(point, low_)) || glm::any(glm::greaterThan(point, high_))) return 0;
  return std::abs(windingNumber(point)) > kHalf ? distanceTo(point) : 0;
}

void InsideTicks::see(double depth_m) {
  if (!(depth_m > kWithin_m)) {
    row_ = 0;
    return;
  }
  ++all_;
  ++row_;
  if (row_ <= 2) single_ += row_ == 1 ? 1 : -1;
  longest_ = std::max(longest_, row_);
  deepest_m_ = std::max(deepest_m_, depth_m);
}

}  // namespace haptics::eval

#include "tests/eval/winding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "tests/eval/closest_on_triangle.h"

namespace haptics::eval {

WindingMesh::WindingMesh(std::span<const Vec3f> vertices, std::span<const TriangleIndices> triangles)
    : vertices_(vertices.begin(), vertices.end()), corners_(triangles.begin(), triangles.end()) {
  for (const TriangleIndices& t : triangles) triangles_.push_back({vertices_[t[0]], vertices_[t[1]], vertices_[t[2]]});
  low_ = high_ = vertices_.front();
  for (const Vec3 vertex : vertices_) {
    low_ = glm::min(low_, vertex);
    high_ = glm::max(high_, vertex);
  }
}

// A half of the angle is the argument of a complex number. Their product has the sum of the arguments but for whole turns,
// which are counted where it passes pi: no arctangent a triangle.
double WindingMesh::windingNumber(Vec3 point) const {
  struct Way {
    Vec3 to;
    double length;
  };
  std::vector<Way> ways;
  ways.reserve(vertices_.size());
  for (const Vec3 vertex : vertices_) ways.push_back({vertex - point, glm::distance(vertex, point)});

  constexpr std::size_t kBetweenScalings = 8;  // fewer than would under- or overflow
  double re = 1, im = 0;
  int turns = 0;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const auto& [a, la] = ways[corners_[i][0]];
    const auto& [b, lb] = ways[corners_[i][1]];
    const auto& [c, lc] = ways[corners_[i][2]];
    const double volume = glm::dot(a, glm::cross(b, c));
    const double rest = la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
    if (volume == 0 && rest == 0) continue;  // the point is a corner
    const bool positive = im >= 0;
    const double before = re;
    re = before * rest - im * volume;
    im = before * volume + im * rest;
    if (positive == (volume >= 0) && positive != (im >= 0)) turns += positive ? 1 : -1;
    if (i % kBetweenScalings != 0) continue;
    const double size = std::abs(re) + std::abs(im);
    re /= size;
    im /= size;
  }
  return (turns * 2 * std::numbers::pi + std::atan2(im, re)) / (2 * std::numbers::pi);
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

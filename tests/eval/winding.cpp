#include "tests/eval/winding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "tests/eval/closest_on_triangle.h"

namespace haptics::eval {

WindingMesh::WindingMesh(std::span<const Vec3f> vertices, std::span<const TriangleIndices> triangles)
    : vertices_(vertices.begin(), vertices.end()),
      triangles_(triangles.begin(), triangles.end()),
      low_(std::numeric_limits<double>::infinity()),
      high_(-low_) {
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

  double re = 1, im = 0;
  int turns = 0;
  for (const TriangleIndices& t : triangles_) {
    const auto& [a, la] = ways[t[0]];
    const auto& [b, lb] = ways[t[1]];
    const auto& [c, lc] = ways[t[2]];
    const double volume = glm::dot(a, glm::cross(b, c));
    const double rest = la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
    if (volume == 0 && rest == 0) continue;  // the point is a corner
    const bool positive = im >= 0;
    const double realPart = re * rest - im * volume;
    const double imaginaryPart = re * volume + im * rest;
    const double size = std::abs(realPart) + std::abs(imaginaryPart);
    re = realPart / size;
    im = imaginaryPart / size;
    if (positive == (volume >= 0) && positive != (im >= 0)) turns += positive ? 1 : -1;
  }
  return (turns * 2 * std::numbers::pi + std::atan2(im, re)) / (2 * std::numbers::pi);
}

double WindingMesh::distanceTo(Vec3 point) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const TriangleIndices& t : triangles_) {
    const std::array corners{vertices_[t[0]], vertices_[t[1]], vertices_[t[2]]};
    nearest = std::min(nearest, glm::distance(closestOnTriangle(point, corners), point));
  }
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

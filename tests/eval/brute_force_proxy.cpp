#include "tests/eval/brute_force_proxy.h"

#include <algorithm>
#include <limits>

#include "tests/eval/closest_on_triangle.h"

namespace haptics::eval {

BruteForceProxy::BruteForceProxy(const TriMesh& mesh) {
  // Of the largest coordinate: above what rounding makes of a point on a sliver, below any edge.
  constexpr double kTolerance = 0x1p-26;
  double extent = 0;
  for (const TriangleIndices& t : mesh.triangles) {
    triangles_.push_back({Vec3(mesh.vertices[t[0]]), Vec3(mesh.vertices[t[1]]), Vec3(mesh.vertices[t[2]])});
    for (const Vec3 v : triangles_.back()) extent = std::max(extent, glm::length(v));
  }
  tolerance_ = kTolerance * extent;
}

void BruteForceProxy::touch(Vec3 hip) { proxy_ = closestOnThoseAt(hip, std::numeric_limits<double>::infinity(), hip); }

Vec3 BruteForceProxy::follow(Vec3 hip) {
  constexpr double kCloser = 1 - 0x1p-44;
  while (true) {
    const Vec3 next = closestOnThoseAt(proxy_, tolerance_, hip);
    const bool closer = glm::distance(next, hip) < glm::distance(proxy_, hip) * kCloser;
    proxy_ = next;
    if (!closer) return proxy_;
  }
}

Vec3 BruteForceProxy::closestOnThoseAt(Vec3 at, double within, Vec3 hip) const {
  Vec3 best = at;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& t : triangles_) {
    const Vec3 low = glm::min(glm::min(t[0], t[1]), t[2]) - within;
    const Vec3 high = glm::max(glm::max(t[0], t[1]), t[2]) + within;
    if (glm::any(glm::lessThan(at, low)) || glm::any(glm::greaterThan(at, high))) continue;
    if (glm::distance(closestOnTriangle(at, t), at) > within) continue;
    const Vec3 point = closestOnTriangle(hip, t);
    const double distance2 = squaredLength(point - hip);
    if (distance2 >= least) continue;
    least = distance2;
    best = point;
  }
  return best;
}

}  // namespace haptics::eval

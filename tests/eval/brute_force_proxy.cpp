#include "tests/eval/brute_force_proxy.h"

#include <algorithm>
#include <limits>

namespace haptics::eval {
namespace {

/// Ericson, Real-Time Collision Detection, 5.1.5: another way to the closest point than the production one.
Vec3 closestOnTriangle(Vec3 p, const std::array<Vec3, 3>& t) {
  const Vec3 ab = t[1] - t[0];
  const Vec3 ac = t[2] - t[0];
  const double d1 = glm::dot(ab, p - t[0]);
  const double d2 = glm::dot(ac, p - t[0]);
  if (d1 <= 0 && d2 <= 0) return t[0];
  const double d3 = glm::dot(ab, p - t[1]);
  const double d4 = glm::dot(ac, p - t[1]);
  if (d3 >= 0 && d4 <= d3) return t[1];
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return t[0] + ab * (d1 / (d1 - d3));
  const double d5 = glm::dot(ab, p - t[2]);
  const double d6 = glm::dot(ac, p - t[2]);
  if (d6 >= 0 && d5 <= d6) return t[2];
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return t[0] + ac * (d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return glm::mix(t[1], t[2], (d4 - d3) / ((d4 - d3) + (d5 - d6)));
  return t[0] + ab * (vb / (va + vb + vc)) + ac * (vc / (va + vb + vc));
}

}  // namespace

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

#include "haptic_server/simplification/fit.h"

#include <algorithm>
#include <cmath>

#include "common/interruption/interruption.h"

namespace haptics {
namespace {

struct Misfit {
  double largest_m = 0;
  std::vector<Vec3> pull;      ///< Of each vertex of the copy: weighted sum of what is missing.
  std::vector<double> weight;  ///< Of the weights' squares.
};

ClosestPoint footOn(const CollisionMesh& surface, Vec3 place) {
  int spent = 0;
  return surface.closestFoot(place, static_cast<int>(surface.triangleCount()) + 1, spent);
}

/// Barycentric coordinates of a point in a triangle.
Vec3 weightsIn(const TriangleRecord& triangle, Vec3 point) {
  const Vec3 normal = glm::cross(triangle.corner(1) - triangle.corner(0), triangle.corner(2) - triangle.corner(0));
  Vec3 weights;
  for (int k = 0; k < 3; ++k) {
    const Vec3 a = triangle.corner((k + 1) % 3) - point;
    const Vec3 b = triangle.corner((k + 2) % 3) - point;
    weights[k] = glm::dot(glm::cross(a, b), normal) / squaredLength(normal);
  }
  return weights;
}

Misfit misfitOf(const TriMesh& copy, const std::vector<Vec3f>& original) {
  const auto surface = buildCollisionMesh(copy.vertices, copy.triangles);
  Misfit misfit{0, std::vector<Vec3>(copy.vertices.size(), Vec3(0)), std::vector<double>(copy.vertices.size())};
  for (const Vec3f v : original) {
    interruptionPoint();
    const ClosestPoint foot = footOn(*surface, Vec3(v));
    const TriangleRecord& triangle = surface->triangle(foot.triangle);
    const Vec3 weights = weightsIn(triangle, foot.point);
    const TriangleIndices& corners = copy.triangles[surface->canonical(foot.triangle)];
    // A record may begin at another corner than the mesh's triangle does.
    for (int k = 0; k < 3; ++k) {
      const auto corner = std::find_if(corners.begin(), corners.end(),
                                       [&](std::uint32_t c) { return Vec3(copy.vertices[c]) == triangle.corner(k); });
      misfit.pull[*corner] += weights[k] * (Vec3(v) - foot.point);
      misfit.weight[*corner] += weights[k] * weights[k];
    }
    misfit.largest_m = std::max(misfit.largest_m, std::sqrt(foot.squaredDistance));
  }
  return misfit;
}

}  // namespace

std::vector<Vec3f> everyNth(const std::vector<Vec3f>& vertices, std::size_t most) {
  const std::size_t step = std::max<std::size_t>(1, vertices.size() / most);
  std::vector<Vec3f> chosen;
  for (std::size_t v = 0; v < vertices.size(); v += step) chosen.push_back(vertices[v]);
  return chosen;
}

double deviationOf(const std::vector<Vec3f>& places, const CollisionMesh& surface) {
  double most = 0;
  for (const Vec3f place : places) {
    interruptionPoint();
    most = std::max(most, footOn(surface, Vec3(place)).squaredDistance);
  }
  return std::sqrt(most);
}

TriMesh fitted(TriMesh copy, const std::vector<Vec3f>& original) {
  constexpr int kRounds = 6;
  constexpr double kPart = 0.7;     // of a round's move: neighbours move too
  constexpr double kMinWeight = 1;  // a vertex that few places tell of moves little
  Misfit misfit = misfitOf(copy, original);
  for (int round = 0; round < kRounds; ++round) {
    TriMesh moved = copy;
    for (std::size_t v = 0; v < moved.vertices.size(); ++v) {
      moved.vertices[v] += Vec3f(kPart * misfit.pull[v] / std::max(misfit.weight[v], kMinWeight));
    }
    if (!checkMesh(moved)) break;
    Misfit next = misfitOf(moved, original);
    if (!(next.largest_m < misfit.largest_m)) break;
    copy = std::move(moved);
    misfit = std::move(next);
  }
  return copy;
}

}  // namespace haptics

#include "haptic_server/engine/effects/near_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "haptic_server/engine/geometry/enclosure.h"
#include "haptic_server/engine/geometry/neighbours.h"

namespace haptics {
namespace {

/// Calls look(triangle, squared_m2) for triangles that may hold something nearer than the root of squared_m2, which it lowers.
template <class Look>
void visitNear(const CollisionMesh& mesh, Vec3 hip, double& squared_m2, Allowance& allowance, Look look) noexcept {
  allowance.spend(Allowance::kQuery);
  mesh.hierarchy().visitNear(
      hip, allowance,
      [&](std::uint32_t begin, std::uint32_t end) noexcept {
        allowance.spend(Allowance::kNearTriangle * (end - begin));
        for (std::uint32_t t = begin; t < end; ++t) look(t, squared_m2);
        return squared_m2;
      },
      squared_m2);
}

/// Seen alike from both of its polygons.
[[nodiscard]] bool isSharp(const CollisionMesh& mesh, std::uint32_t triangle, int edge, Allowance& allowance) noexcept {
  const std::uint32_t across = mesh.triangle(triangle).neighbour(edge);
  if (across == kNoTriangle) return true;
  allowance.spend(Allowance::kTriangle);
  constexpr double kSharp = 0.8660254037844387 + 1e-9;  // cosine of 30 degrees: those of just so much belong to it
  return glm::dot(mesh.faceNormal(triangle), mesh.faceNormal(across)) <= kSharp;
}

/// Of a sharp edge on its way out of one of its ends: unit, the mean with the one other sharp edge that goes on there; 0 where none
/// or several do.
[[nodiscard]] Vec3 tangentAt(const CollisionMesh& mesh, std::uint32_t triangle, int corner, Vec3 outward,
                             Allowance& allowance) noexcept {
  const std::uint32_t apex = mesh.triangle(triangle).vertexAt(corner);
  const Vec3 at = mesh.triangle(triangle).corner(corner);
  Vec3 sum(0);
  int halves = 0;  // of edges: each is met from both of its polygons
  const auto addEdges = [&](std::uint32_t t, int k) noexcept {
    allowance.spend(Allowance::kTriangle);
    for (const int edge : {k, previousCorner(k)}) {
      if (!isSharp(mesh, t, edge, allowance)) continue;
      const TriangleRecord& record = mesh.triangle(t);
      const int other = record.vertexAt(edge) == apex ? nextCorner(edge) : edge;
      const bool isRim = record.neighbour(edge) == kNoTriangle;
      sum += (isRim ? 2.0 : 1.0) * unitOrZero(record.corner(other) - at);
      halves += isRim ? 2 : 1;
    }
    return halves <= 4 && !allowance.isSpent();
  };
  addEdges(triangle, corner);
  visitFan(mesh, triangle, corner, addEdges);
  if (halves != 4) return Vec3(0);
  return unitOrZero(2.0 * outward + sum / 2.0);
}

[[nodiscard]] Vec3 tangent(const CollisionMesh& mesh, std::uint32_t triangle, int edge, double part,
                           Allowance& allowance) noexcept {
  /// From a corner the tangent comes over this way, or a quarter of a shorter edge.
  constexpr double kCorner_m = 2e-3;
  const int end = nextCorner(edge);
  const Vec3 way = mesh.triangle(triangle).corner(end) - mesh.triangle(triangle).corner(edge);
  const double length_m = glm::length(way);
  const Vec3 along = way / length_m;
  const Vec3 atBegin = -tangentAt(mesh, triangle, edge, -along, allowance);
  const Vec3 atEnd = tangentAt(mesh, triangle, end, along, allowance);
  const bool endsAtBegin = atBegin == Vec3(0), endsAtEnd = atEnd == Vec3(0);
  const double corner_m = std::min(kCorner_m, length_m / 4);
  double share = 1;
  if (endsAtBegin) share = std::min(share, part * length_m / corner_m);
  if (endsAtEnd) share = std::min(share, (1 - part) * length_m / corner_m);
  return share * unitOrZero(glm::mix(endsAtBegin ? along : atBegin, endsAtEnd ? along : atEnd, part));
}

}  // namespace

NearMesh nearestPlace(const CollisionMesh& mesh, Vec3 hip, double within_m, Allowance& allowance) noexcept {
  NearMesh near;
  double squared_m2 = within_m * within_m;
  visitNear(mesh, hip, squared_m2, allowance, [&](std::uint32_t t, double& nearest_m2) noexcept {
    const ClosestPoint foot = closestOn(mesh.triangle(t), t, hip);
    if (!(foot.squaredDistance < nearest_m2)) return;
    nearest_m2 = foot.squaredDistance;
    near.isFound = true;
    near.point = foot.point;
  });
  return near;
}

NearMesh nearestVertex(const CollisionMesh& mesh, Vec3 hip, double within_m, Allowance& allowance) noexcept {
  NearMesh near;
  double squared_m2 = within_m * within_m;
  visitNear(mesh, hip, squared_m2, allowance, [&](std::uint32_t t, double& nearest_m2) noexcept {
    for (int k = 0; k < 3; ++k) {
      const Vec3 corner = mesh.triangle(t).corner(k);
      if (!(squaredLength(corner - hip) < nearest_m2)) continue;
      nearest_m2 = squaredLength(corner - hip);
      near.isFound = true;
      near.point = corner;
    }
  });
  return near;
}

NearMesh nearestEdge(const CollisionMesh& mesh, Vec3 hip, double within_m, Allowance& allowance) noexcept {
  NearMesh near;
  double squared_m2 = within_m * within_m, part = 0;
  std::uint32_t triangle = kNoTriangle;
  int edge = 0;
  visitNear(mesh, hip, squared_m2, allowance, [&](std::uint32_t t, double& nearest_m2) noexcept {
    for (int k = 0; k < 3; ++k) {
      const Vec3 begin = mesh.triangle(t).corner(k), way = mesh.triangle(t).corner(nextCorner(k)) - begin;
      if (way == Vec3(0)) continue;
      const double its = std::clamp(glm::dot(hip - begin, way) / squaredLength(way), 0.0, 1.0);
      const Vec3 point = begin + its * way;
      if (!(squaredLength(point - hip) < nearest_m2) || !isSharp(mesh, t, k, allowance)) continue;
      nearest_m2 = squaredLength(point - hip);
      triangle = t;
      edge = k;
      part = its;
      near.point = point;
    }
  });
  near.isFound = triangle != kNoTriangle;
  if (near.isFound) near.along = tangent(mesh, triangle, edge, part, allowance);
  return near;
}

NearMesh inside(const CollisionMesh& mesh, Vec3 hip, double within_m, Allowance& allowance) noexcept {
  if (windingNumber(mesh, hip, allowance) <= 0) return {};
  NearMesh near;
  if (within_m > 0) near = nearestPlace(mesh, hip, within_m, allowance);
  near.depth_m = near.isFound ? glm::distance(near.point, hip) : within_m;
  near.isFound = true;
  return near;
}

}  // namespace haptics

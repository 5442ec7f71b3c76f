#pragma once

#include <algorithm>
#include <cstdint>

#include "haptic_server/engine/geometry/collision_mesh.h"
#include "haptic_server/engine/geometry/enclosure.h"

/// What the searches for contacts ask of one surface. Object frame, metres; `allowance` pays.
namespace haptics::surface_queries {

/// Units (Allowance) of beginning a query that ranks nothing, of the distance from a triangle's plane, and from its box.
inline constexpr std::int64_t kQuery = 64, kPlane = 24, kBox = 12;
/// A point that is so deep behind a face is looked for inside, m: at less than that rounding decides.
inline constexpr double kSurelyBehind_m = 1e-6;

/// Its plane is no nearer.
[[nodiscard]] inline bool isPlaneFarther(const TriangleRecord& triangle, Vec3 at, double squared,
                                         Allowance& allowance) noexcept {
  constexpr double kAsFar = 1 - 0x1p-30;  // in the same plane is not nearer
  allowance.spend(kPlane);
  const Vec3 normal = triangle.areaNormal();
  const double height = glm::dot(normal, at - triangle.corner(0));
  return height * height > kAsFar * squared * squaredLength(normal);
}
/// The box about it is.
[[nodiscard]] inline bool isBoxFarther(const TriangleRecord& triangle, Vec3 at, double squared,
                                       Allowance& allowance) noexcept {
  constexpr double kSurelyFarther = 1 + 0x1p-30;  // more than rounding may do
  allowance.spend(kBox);
  const auto& rows = triangle.rows;
  Vec3 gap;
  for (int d = 0; d < 3; ++d) {
    const auto& [a, b, c, neighbour] = rows[static_cast<std::size_t>(d)];
    gap[d] = std::max({std::min({a, b, c}) - at[d], at[d] - std::max({a, b, c}), 0.0});
  }
  return squaredLength(gap) > kSurelyFarther * squared;
}
/// Its plane is no nearer. Else what the closest point costs is spent.
[[nodiscard]] inline bool isFarther(const TriangleRecord& triangle, Vec3 at, double squared,
                                    Allowance& allowance) noexcept {
  if (isPlaneFarther(triangle, at, squared, allowance)) return true;
  allowance.spend(Allowance::kNearTriangle);
  return false;
}

/// Shows each triangle that may be nearer than `nearest`.
template <class Look>
void visit(const CollisionMesh& surface, Vec3 at, const ClosestPoint& nearest, Look look,
           Allowance& allowance) noexcept {
  allowance.spend(kQuery);
  surface.hierarchy().visitNear(
      at, allowance,
      [&](std::uint32_t begin, std::uint32_t end) noexcept {
        for (std::uint32_t t = begin; t < end; ++t) look(t);
        return nearest.squaredDistance;
      },
      nearest.squaredDistance);
}

/// The nearest place of the surface; no triangle where there is none nearer than that.
[[nodiscard]] inline ClosestPoint nearestWithin(const CollisionMesh& surface, Vec3 at, double distance_m,
                                                Allowance& allowance) noexcept {
  ClosestPoint nearest;
  nearest.squaredDistance = distance_m * distance_m;
  const auto look = [&](std::uint32_t t) noexcept {
    if (isFarther(surface.triangle(t), at, nearest.squaredDistance, allowance)) return;
    const ClosestPoint point = closestOn(surface.triangle(t), t, at);
    if (point.squaredDistance < nearest.squaredDistance) nearest = point;
  };
  visit(surface, at, nearest, look, allowance);
  return nearest;
}

/// Behind a face is not inside: a plate's far face has all that lies above the plate behind it.
[[nodiscard]] inline bool isInside(const CollisionMesh& surface, Vec3 at, const ClosestPoint& nearest,
                                   Allowance& allowance) noexcept {
  if (surface.closed() && surface.anySelfIntersecting()) return windingNumber(surface, at, allowance) > 0;
  return nearest.triangle != kNoTriangle && !surface.isOutside(nearest, at);
}
/// And no deeper than that.
[[nodiscard]] inline bool isInside(const CollisionMesh& surface, Vec3 at, double depth_m,
                                   Allowance& allowance) noexcept {
  return isInside(surface, at, nearestWithin(surface, at, depth_m, allowance), allowance);
}

}  // namespace haptics::surface_queries

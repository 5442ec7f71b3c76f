#include "haptic_server/engine/contact/surface_shift.h"

#include <array>
#include <cmath>
#include <limits>

namespace haptics {

Vec3 movedWith(const TriangleRecord& before, const TriangleRecord& now, Vec3 point) noexcept {
  const Vec3 a = before.corner(0), ab = before.corner(1) - a, ac = before.corner(2) - a;
  const Vec3 normal = glm::cross(ab, ac);
  const double area2 = squaredLength(normal);
  if (area2 == 0) return point + (now.corner(0) - a);
  const Vec3 along = point - a;
  const double b = glm::dot(glm::cross(along, ac), normal) / area2;
  const double c = glm::dot(glm::cross(ab, along), normal) / area2;
  const std::array way{now.corner(0) - a, now.corner(1) - before.corner(1), now.corner(2) - before.corner(2)};
  return point + way[0] * (1 - b - c) + way[1] * b + way[2] * c;
}

Vec3 surfaceShift(const CollisionMesh& before, const CollisionMesh& now, Vec3 place, double farthest_m,
                  Allowance& allowance) noexcept {
  const double reach = 2 * farthest_m;
  const Vec3 gap = glm::max(glm::max(before.low() - place, place - before.high()), Vec3(0));
  if (squaredLength(gap) > reach * reach) return Vec3(0);
  ClosestPoint nearest;
  nearest.squaredDistance = reach * reach;
  allowance.spend(Allowance::kQuery);
  before.hierarchy().visitNear(
      place, allowance,
      [&](std::uint32_t begin, std::uint32_t end) noexcept {
        allowance.spend(Allowance::kNearTriangle * (end - begin));
        for (std::uint32_t t = begin; t < end; ++t) {
          const ClosestPoint foot = closestOn(before.triangle(t), t, place);
          if (foot.squaredDistance < nearest.squaredDistance) nearest = foot;
        }
        return nearest.squaredDistance;
      },
      std::nextafter(nearest.squaredDistance, std::numeric_limits<double>::infinity()));
  if (nearest.triangle == kNoTriangle) return Vec3(0);
  return movedWith(before.triangle(nearest.triangle), now.triangle(nearest.triangle), nearest.point) - nearest.point;
}

}  // namespace haptics

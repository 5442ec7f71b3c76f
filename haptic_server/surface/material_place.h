#pragma once

#include <array>
#include <cmath>

#include "haptic_server/geometry/barycentric.h"

namespace haptics {

/// Where a point of a deformed triangle is on the material, that is on the mesh as it was before lattice, residue and dents:
/// fields are given there. Object frame, metres.
///
/// Deviation from paper 4.3, whose height is that at the IHIP: there a field would swim through a body that deforms. "The
/// height should be at IHIP and not at HIP" for the same reason: different depths are to have the same height.
class MaterialPlace {
 public:
  using Corners = std::array<Vec3, 3>;

  /// @param now  The triangle, deformed.
  /// @param before  Its corners on the material.
  MaterialPlace(const TriangleRecord& now, const Corners& before, Vec3 point) noexcept : before_(before) {
    const Vec3 share = barycentric(now, point);
    place_ = before[0] * share[0] + before[1] * share[1] + before[2] * share[2];
    const Vec3 a = now.corner(0), edge1 = now.corner(1) - a, edge2 = now.corner(2) - a;
    const Vec3 normal = glm::cross(edge1, edge2);
    const double area2 = squaredLength(normal);
    if (!(area2 > 0)) return;
    along1_ = glm::cross(edge2, normal) / area2;
    along2_ = glm::cross(normal, edge1) / area2;
    across_ = normal / std::sqrt(area2);
  }

  [[nodiscard]] Vec3 place() const noexcept { return place_; }
  /// Of a field with this gradient on the material, the gradient on the deformed body: along the triangle's edges the field
  /// changes as it does on the material, across the triangle by the same per metre.
  [[nodiscard]] Vec3 gradient(Vec3 onMaterial) const noexcept {
    const Vec3 edge1 = before_[1] - before_[0], edge2 = before_[2] - before_[0];
    return along1_ * glm::dot(onMaterial, edge1) + along2_ * glm::dot(onMaterial, edge2) +
           across_ * glm::dot(onMaterial, unitOrZero(glm::cross(edge1, edge2)));
  }

 private:
  Corners before_;
  Vec3 place_;
  Vec3 along1_{0}, along2_{0}, across_{0};  // dual to the edges from corner 0 and to the unit normal
};

}  // namespace haptics

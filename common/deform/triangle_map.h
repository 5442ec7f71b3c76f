#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "common/maths/barycentric.h"
#include "common/maths/vec.h"

namespace haptics {

/// From a deformed triangle to where it is on the material, that is on the mesh as it was before lattice, residue and dents:
/// fields are given there. One function for both processes. Object frame, metres.
///
/// Deviation from paper 4.3, whose height is that at the IHIP: there a field would swim through a body that deforms. The
/// paper's own reason for the IHIP, that the height is not to change with the depth where the contact point is the same, asks
/// for this.
class TriangleMap {
 public:
  using Corners = std::array<Vec3, 3>;

  TriangleMap(const Corners& now, const Corners& onMaterial) noexcept : now_(now), material_(onMaterial) {}

  /// On the plane of the triangle on the material; near enough to be a place for triangles that are as good as gone too.
  [[nodiscard]] Vec3 place(Vec3 point) const noexcept {
    const Vec3 share = barycentric(now_[0], now_[1], now_[2], point);
    const double second = std::clamp(share[1], -kMaxShare, kMaxShare);
    const double third = std::clamp(share[2], -kMaxShare, kMaxShare);
    return material_[0] * (1 - second - third) + material_[1] * second + material_[2] * third;
  }

  /// Of a field with this gradient on the material, the gradient on the deformed body: along the triangle's edges the field
  /// changes as it does on the material, across the triangle by the same per metre. 0 on a triangle that is as good as gone.
  [[nodiscard]] Vec3 gradient(Vec3 onMaterial) const noexcept {
    const Vec3 edge1 = now_[1] - now_[0], edge2 = now_[2] - now_[0], normal = glm::cross(edge1, edge2);
    const double area2 = squaredLength(normal);
    const Vec3 was1 = material_[1] - material_[0], was2 = material_[2] - material_[0],
               wasNormal = glm::cross(was1, was2);
    const double wasArea2 = squaredLength(wasNormal);
    if (!(area2 > kGone * wasArea2)) return Vec3(0);
    const double across = wasArea2 > 0 ? glm::dot(onMaterial, wasNormal) / std::sqrt(wasArea2 * area2) : 0;
    const Vec3 along =
        glm::cross(edge2, normal) * glm::dot(onMaterial, was1) + glm::cross(normal, edge1) * glm::dot(onMaterial, was2);
    return along / area2 + normal * across;
  }

 private:
  static constexpr double kGone = 1e-24;  // squared areas: sides of a millionth
  static constexpr double kMaxShare = 1e6;

  Corners now_, material_;
};

}  // namespace haptics

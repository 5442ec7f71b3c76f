#pragma once

#include <array>
#include <cstddef>

#include "common/maths/vec.h"
#include "haptic_server/engine/contact/contact.h"

namespace haptics {

/// Fraction of a length at which planes of the same normal count as different. Larger leaves the IHIP below them.
inline constexpr double kRegular = 1e-9;

/// x >= 0 of products x = depth, in the first `count` rows; where that would be negative, 0 without its row.
[[nodiscard]] inline Vec3 notNegative(glm::dmat3 products, Vec3 depth, std::size_t count) noexcept {
  for (int i = 0; i < 3; ++i) products[i][i] *= 1 + kRegular;
  for (auto active = count;; --active) {
    const Vec3 x = glm::inverse(products) * depth;
    int least = 0;
    for (int i = 1; i < 3; ++i) {
      if (x[i] < x[least]) least = i;
    }
    if (!(x[least] < 0)) return x;
    if (active == 0) return Vec3(0);
    for (int j = 0; j < 3; ++j) products[least][j] = products[j][least] = least == j;
    depth[least] = 0;
  }
}

/// Tangent planes of the surfaces that hold the IHIP; world, m.
struct HeldPlanes {
  struct Plane {
    Vec3 point{0};
    Vec3 normal{0};  ///< Outward, unit.
  };
  std::array<Plane, ContactState::kMaxHolding> plane;
  std::size_t count = 0;

  void add(Vec3 point, Vec3 normal) noexcept { plane[count++] = {point, normal}; }

  /// A point, or of those outside of all planes the nearest one.
  /// @param[out] parts  What each plane's normal has of the way there; not negative.
  [[nodiscard]] Vec3 nearestOutside(Vec3 point, Vec3& parts) const noexcept {
    glm::dmat3 products(1);
    Vec3 depth(0);
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = 0; j < count; ++j) {
        products[static_cast<int>(i)][static_cast<int>(j)] = glm::dot(plane[i].normal, plane[j].normal);
      }
      depth[static_cast<int>(i)] = glm::dot(plane[i].normal, plane[i].point - point);
    }
    parts = notNegative(products, depth, count);
    Vec3 out = point;
    for (std::size_t i = 0; i < count; ++i) out += parts[static_cast<int>(i)] * plane[i].normal;
    return out;
  }
};

}  // namespace haptics

#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/deform/dent.h"
#include "common/maths/elementary.h"
#include "common/maths/sse.h"
#include "haptic_server/engine/geometry/closest_point.h"
#include "haptic_server/engine/geometry/collision_mesh.h"
#include "haptic_server/engine/geometry/neighbours.h"
#include "haptic_server/engine/geometry/simd.h"

namespace haptics {

/// Falloff::at() for the three corners of a triangle, bit-identical.
[[nodiscard]] inline Double4 partsOf(const Dent& dent, const Vec3x4& corners, const Falloff& falloff) noexcept {
  const double inverse2 = 1 / (falloff.radius_m() * falloff.radius_m());
  const Double4 inside = broadcast(1) - squaredLength(corners - broadcast(Vec3(dent.centre))) * broadcast(inverse2);
  Double4 power = inside;
  for (unsigned i = 1; i < falloff.degree(); ++i) power = power * inside;
  return select(inside > broadcast(0), power, broadcast(0));
}

/// The corners; last, the first one again.
[[nodiscard]] inline Vec3x4 cornersAtOnce(const TriangleRecord& r) noexcept {
  return {threeAndFirst(r.rows[0]), threeAndFirst(r.rows[1]), threeAndFirst(r.rows[2])};
}

/// The first three, rounded to floats; the fourth float stays as it is.
inline void putFirstThree(std::array<float, 4>& floats, Double4 v) noexcept {
  constexpr int kFourth = 8;
  const __m128 rounded = _mm_movelh_ps(_mm_cvtpd_ps(v.low), _mm_cvtpd_ps(v.high));
  _mm_store_ps(floats.data(), _mm_blend_ps(rounded, _mm_load_ps(floats.data()), kFourth));
}

/// A triangle with its corners where the dents have them: dented() of each, all at once.
[[nodiscard]] inline TriangleRecord dented(const TriangleRecord& rest, std::span<const Dent> dents,
                                           const Falloff& falloff) noexcept {
  TriangleRecord r = rest;
  for (const Dent& dent : dents) {
    const Vec3x4 before = cornersAtOnce(r);
    const Vec3x4 now = before + broadcast(Vec3(dent.displacement)) * partsOf(dent, before, falloff);
    putFirstThree(r.rows[0], now.x);
    putFirstThree(r.rows[1], now.y);
    putFirstThree(r.rows[2], now.z);
  }
  return r;
}

/// A surface whose vertices dents displace, triangle by triangle as they are asked for. Nothing of it is stored but the last, so that a
/// shape that changes in every tick costs only what the search looks at, however large the part that changes; boxes and
/// normals are never refitted, for the surface at rest finds the contact, and this one only where on it the IHIP is.
class DentedSurface {
 public:
  /// Triangles that a search may look at. Displacements are small against the mesh, so that a search ends where it began
  /// or a few triangles on; more would bound the tick less.
  static constexpr int kBudget = 96;

  DentedSurface(const CollisionMesh& rest, std::span<const Dent> dents, const Falloff& falloff) noexcept
      : rest_(rest), dents_(dents), falloff_(falloff) {}

  /// Until the next one is asked for.
  [[nodiscard]] const TriangleRecord& triangle(std::uint32_t t) noexcept {
    if (t != lastNumber_) {
      last_ = dented(rest_.triangle(t), dents_, falloff_);
      lastNumber_ = t;
    }
    return last_;
  }

  /// The neighborhood watch of paper 3.2 on the dented triangles: from a triangle down to a point that no triangle around is
  /// closer to h than, or to the best of the `most` that it may look at. Adds those looked at to `spent`.
  [[nodiscard]] ClosestPoint closestFrom(std::uint32_t start, Vec3 h, int& spent, int most = kBudget) noexcept {
    ClosestPoint best = footOn(start, h, spent);
    for (std::uint32_t t = kNoTriangle; spent < most && t != best.triangle;) {
      t = best.triangle;
      const int index = best.index;
      const auto consider = [&](std::uint32_t other, int) noexcept {
        const ClosestPoint foot = footOn(other, h, spent);
        if (foot.squaredDistance < best.squaredDistance) best = foot;
        return spent < most;
      };
      if (best.feature == Feature::kLine && rest_.triangle(t).neighbour(index) != kNoTriangle) {
        consider(rest_.triangle(t).neighbour(index), 0);
      } else if (best.feature == Feature::kVertex) {
        visitFan(rest_, t, index, consider);
      }
    }
    return best;
  }

  /// As CollisionMesh::normal(), of the dented triangles; not of length 1, zero where there is none.
  [[nodiscard]] Vec3 normal(const ClosestPoint& foot) noexcept {
    const Vec3 own = triangle(foot.triangle).areaNormal();
    if (foot.feature == Feature::kPolygon || rest_.onBoundary(foot)) return own;
    if (foot.feature == Feature::kLine) {
      return unitOrZero(own) + unitOrZero(triangle(rest_.triangle(foot.triangle).neighbour(foot.index)).areaNormal());
    }
    Vec3 sum = weighted(foot.triangle, foot.index);
    visitFan(rest_, foot.triangle, foot.index, [&](std::uint32_t t, int corner) noexcept {
      sum += weighted(t, corner);
      return true;
    });
    return sum;
  }

 private:
  [[nodiscard]] ClosestPoint footOn(std::uint32_t t, Vec3 h, int& spent) noexcept {
    ++spent;
    return closestOn(triangle(t), t, h);
  }

  /// By the angle at the corner.
  [[nodiscard]] Vec3 weighted(std::uint32_t t, int corner) noexcept {
    const TriangleRecord& r = triangle(t);
    const Vec3 a = unitOrZero(r.corner(nextCorner(corner)) - r.corner(corner));
    const Vec3 b = unitOrZero(r.corner(previousCorner(corner)) - r.corner(corner));
    return unitOrZero(r.areaNormal()) * elementary::acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
  }

  const CollisionMesh& rest_;
  std::span<const Dent> dents_;
  const Falloff& falloff_;
  TriangleRecord last_;
  std::uint32_t lastNumber_ = kNoTriangle;
};

}  // namespace haptics

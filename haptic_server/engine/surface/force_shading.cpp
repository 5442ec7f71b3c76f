#include "haptic_server/engine/surface/force_shading.h"

#include <algorithm>
#include <cmath>

#include "haptic_server/engine/geometry/dented_surface.h"

namespace haptics {
namespace {

/// Polygons that the projection may pass through: it leads a fraction of an edge away. Bounds the tick where the mesh is
/// crumpled; what is not found then is not shaded.
constexpr int kMaxPolygons = 16;
/// Steps of Newton's method in a polygon; one is usually enough.
constexpr int kMaxNewtonSteps = 4;
/// Fraction of the depth (on the surface, of its square times an edge): a projection that misses h by less has arrived.
constexpr double kMiss = 0x1p-20;
/// Fraction of the polygon's height: farther beyond a line is in the next polygon.
constexpr double kBeyondLine = 0x1p-20;
/// Depth times curvature (p tan(angle) over the edge's length) from which the weight falls, and at which it is 0; at 1
/// the lines along the normals meet. Larger shades deeper and steps more where they do.
constexpr double kFadesFrom = 0.5;
constexpr double kFadesTo = 0.9;
/// Cosine of N_s and the polygon's normal at which the weight is 0, and from which it is whole: normals that lie in the
/// polygon or point into it describe nothing.
constexpr double kMinCosine = 0.1;
constexpr double kGoodCosine = 0.3;
/// 0 up to `from`, 1 from `to` on, C1 between.
[[nodiscard]] double smoothStep(double from, double to, double x) noexcept {
  if (x <= from) return 0;
  if (x >= to) return 1;
  const double s = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

/// A polygon with its corners' normals: x(u, v) on it, n(u, v) there, u and v the parts of corners 1 and 2.
class ShadedPolygon {
 public:
  ShadedPolygon(const TriangleRecord& triangle, const ShadingRecord& shading) noexcept
      : shading_(shading),
        corner_(triangle.corner(0)),
        edge1_(triangle.corner(1) - corner_),
        edge2_(triangle.corner(2) - corner_),
        normal_(shading.normal(0)),
        turn1_(shading.normal(1) - normal_),
        turn2_(shading.normal(2) - normal_),
        areaNormal_(glm::cross(edge1_, edge2_)),
        twiceArea_(glm::length(areaNormal_)) {}

  /// About the right s for what is so far from the polygon's plane: exact where the normals rise from it all alike, as on a
  /// sphere.
  [[nodiscard]] double alongNormals(double distance_m) const noexcept {
    const double along = glm::dot(normal_ + (turn1_ + turn2_) * (1.0 / 3), areaNormal_);
    return along > kMinCosine * twiceArea_ ? distance_m * twiceArea_ / along : distance_m;
  }

  /// Solves h = x(u, v) - s n(u, v) from the middle of the polygon and from about the right s. False where there is no
  /// solution to be found.
  [[nodiscard]] bool project(const Vec3& h, double& s) noexcept {
    u_ = v_ = 1.0 / 3;
    for (int i = 0; i < kMaxNewtonSteps; ++i) {
      const Vec3 n = normal_ + turn1_ * u_ + turn2_ * v_;
      const Vec3 a = edge1_ - turn1_ * s;
      const Vec3 b = edge2_ - turn2_ * s;
      const Vec3 missing = h - corner_ - edge1_ * u_ - edge2_ * v_ + n * s;
      const Vec3 along = glm::cross(a, b);
      const Vec3 turned = glm::cross(n, missing);
      const double scale = 1 / glm::dot(n, along);
      const double du = glm::dot(b, turned) * scale;
      const double dv = -glm::dot(a, turned) * scale;
      const double ds = -glm::dot(along, missing) * scale;
      u_ += du;
      v_ += dv;
      s += ds;
      // All that the step left out: the equation is bilinear.
      const double left2 = ds * ds * squaredLength(turn1_ * du + turn2_ * dv);
      if (!std::isfinite(left2)) return false;
      if (left2 <= kMiss * kMiss * (s * s + kMiss * kMiss * squaredLength(edge1_))) return true;
    }
    return false;
  }

  /// The edge beyond which the projection has arrived, or -1.
  [[nodiscard]] int beyond() const noexcept {
    const Vec3 parts = this->parts();
    int least = 0;
    for (int k = 1; k < 3; ++k) {
      if (parts[k] < parts[least]) least = k;
    }
    return parts[least] < -kBeyondLine ? nextCorner(least) : -1;
  }

  /// What each corner has of where the projection has arrived.
  [[nodiscard]] Vec3 parts() const noexcept { return {1 - u_ - v_, u_, v_}; }

  /// @param s  In lengths of the normal, which is a little less than 1.
  [[nodiscard]] ShadedPoint at(std::uint32_t t, double s) const noexcept {
    const Vec3 parts = this->parts();
    const Vec3 n = interpolatedNormal(shading_, parts);
    const double length = glm::length(n);
    const double cosine = glm::dot(areaNormal_, n) / (twiceArea_ * length);
    ShadedPoint shaded{.triangle = t, .normal = n * (1 / length), .depth_m = s * length};
    const double bend = std::abs(shaded.depth_m) * curvature(parts, shaded.depth_m > 0);
    shaded.weight = (1 - smoothStep(kFadesFrom, kFadesTo, bend)) * smoothStep(kMinCosine, kGoodCosine, cosine);
    shaded.bulge_m = bulge(parts);
    return shaded;
  }

 private:
  /// Curvature of the surface that the normals describe, on the side of h on which lines along the normals meet.
  [[nodiscard]] double curvature(Vec3 parts, bool within) const noexcept {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      sum +=
          std::max(parts[k], 0.0) * (within ? shading_.roundness(k) : shading_.hollowness[static_cast<std::size_t>(k)]);
    }
    return sum;
  }

  /// Height of the quadratic surface over the polygon.
  [[nodiscard]] double bulge(Vec3 parts) const noexcept {
    return (parts[0] * parts[1] * glm::dot(edge1_, turn1_) + parts[0] * parts[2] * glm::dot(edge2_, turn2_) +
            parts[1] * parts[2] * glm::dot(edge2_ - edge1_, turn2_ - turn1_)) /
           2;
  }

  const ShadingRecord& shading_;
  Vec3 corner_, edge1_, edge2_;
  Vec3 normal_, turn1_, turn2_;
  Vec3 areaNormal_;
  double twiceArea_;
  double u_ = 0, v_ = 0;
};

[[nodiscard]] bool isSharp(const ShadingRecord& r, const ClosestPoint& foot) noexcept {
  if (foot.feature == Feature::kLine) return r.sharpLine(foot.index);
  return foot.feature == Feature::kVertex && r.sharpVertex(foot.index);
}

struct AtRest {
  const CollisionMesh& surface;
  const ShadingNormals& shading;

  struct Polygon {
    const TriangleRecord& triangle;
    const ShadingRecord& normals;
  };
  [[nodiscard]] Polygon polygon(std::uint32_t t) const noexcept { return {surface.triangle(t), shading[t]}; }
};

struct Dented {
  const CollisionMesh& surface;
  const ShadingNormals& shading;
  std::span<const Dent> dents;
  const Falloff& falloff;

  struct Polygon {
    TriangleRecord triangle;
    ShadingRecord normals;
  };
  [[nodiscard]] Polygon polygon(std::uint32_t t) const noexcept {
    Polygon dentedOne{surface.triangle(t), shading[t]};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto corner = static_cast<int>(k);
      const VertexWithNormal vertex =
          dented({Vec3f(dentedOne.triangle.corner(corner)), dentedOne.normals.normal(corner)}, dents, falloff);
      const Vec3f normal(unitOrZero(vertex.normal));
      for (std::size_t d = 0; d < 3; ++d) {
        dentedOne.triangle.rows[d][k] = vertex.place[static_cast<int>(d)];
        dentedOne.normals.rows[d][k] = normal[static_cast<int>(d)];
      }
    }
    return dentedOne;
  }
};

template <class Shape>
[[nodiscard]] ShadedPoint shadeOn(const Shape& shape, const ClosestPoint& foot, const Vec3& h, double depth_m,
                                  Vec3* parts = nullptr) noexcept {
  std::uint32_t t = foot.triangle;
  if (isSharp(shape.shading[t], foot)) return {};
  double s = 0;
  for (int i = 0; i < kMaxPolygons; ++i) {
    if (!shape.shading[t].hasNormals()) return {};
    const auto& [triangle, shading] = shape.polygon(t);
    ShadedPolygon polygon(triangle, shading);
    if (i == 0) s = polygon.alongNormals(depth_m);
    if (!polygon.project(h, s)) return {};
    const int edge = polygon.beyond();
    if (edge < 0 || shading.sharpLine(edge)) {
      if (parts != nullptr) *parts = polygon.parts();
      return polygon.at(t, s);
    }
    t = shape.surface.triangle(t).neighbour(edge);
  }
  return {};
}

}  // namespace

ShadedPoint shade(const CollisionMesh& surface, const ShadingNormals& normals, const ClosestPoint& foot, Vec3 h,
                  double depth_m) noexcept {
  return shadeOn(AtRest{surface, normals}, foot, h, depth_m);
}

ShadedPoint shade(const CollisionMesh& surface, const ShadingNormals& normals, std::span<const Dent> dents,
                  const Falloff& falloff, const ClosestPoint& foot, const Vec3& h, double depth_m,
                  Vec3* parts) noexcept {
  if (dents.empty()) return shadeOn(AtRest{surface, normals}, foot, h, depth_m, parts);
  return shadeOn(Dented{surface, normals, dents, falloff}, foot, h, depth_m, parts);
}

}  // namespace haptics

#pragma once

#include <array>
#include <span>
#include <vector>

#include "common/maths/vec.h"
#include "common/mesh/tri_mesh.h"

namespace haptics::eval {

/// Inside and outside of a closed mesh by its winding number: the sum of the solid angles of all triangles. Holds for
/// meshes that pass through themselves, and shares no code with the production database. Mesh frame, metres.
class SolidOracle {
 public:
  /// Nearer to the surface than this (m) is on it, or than float vertices of the mesh's size are apart, 2^-23 of the
  /// largest coordinate, where that is more: on meshes of more than a quarter of a metre.
  static constexpr double kMinRounding_m = 30e-9;

  SolidOracle(std::span<const Vec3f> vertices, std::span<const TriangleIndices> triangles);

  /// Distance to the surface of a point that the mesh winds around, else 0; 0 also on the surface.
  [[nodiscard]] double depth_m(Vec3 point) const;
  enum class Side { kInside, kOutside, kOnSurface };
  [[nodiscard]] Side side(Vec3 point) const;
  [[nodiscard]] double rounding_m() const noexcept { return rounding_m_; }

  /// 1 within a simple closed mesh whose triangles face outward, 0 outside of it.
  [[nodiscard]] double windingNumber(Vec3 point) const { return windingAt(turned(point)); }
  [[nodiscard]] double distance_m(Vec3 point) const { return distanceFrom(turned(point)); }
  /// Is some triangle at most this far (m) away?
  [[nodiscard]] bool isNear(Vec3 point, double within) const { return isNearTurned(turned(point), within); }

 private:
  struct Box {
    Vec3 low, high;
  };
  struct Face : Box {
    std::array<Vec3, 3> corner;
  };
  /// Is some face, where a test of its box and of that of its group let it through, what is asked for?
  template <class Meets, class Is>
  [[nodiscard]] bool anyFace(Meets meets, Is is) const;
  [[nodiscard]] static Vec3 turned(Vec3 point);
  [[nodiscard]] bool isInBox(Vec3 turned) const;
  [[nodiscard]] int crossingsAbove(Vec3 turned) const;
  [[nodiscard]] double windingAt(Vec3 turned) const;
  [[nodiscard]] double distanceFrom(Vec3 turned) const;
  [[nodiscard]] bool isNearTurned(Vec3 turned, double within) const;

  std::vector<Box> groups_;  // of faces that follow one another, which are mostly neighbours
  std::vector<Face> faces_;  // in a turned frame, so that no ray along an axis meets the edges of a box
  double rounding_m_ = kMinRounding_m;
  Vec3 low_;
  Vec3 high_;
};

}  // namespace haptics::eval

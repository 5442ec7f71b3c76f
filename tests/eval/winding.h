#pragma once

#include <span>
#include <vector>

#include "common/maths/vec.h"
#include "common/mesh/tri_mesh.h"

namespace haptics::eval {

/// A closed mesh, also one that passes through itself, asked what is inside of it: shares no code with the production
/// database. Object frame, metres.
class WindingMesh {
 public:
  WindingMesh(std::span<const Vec3f> vertices, std::span<const TriangleIndices> triangles);

  /// How often the mesh winds around a point that is not on it: the sum of the solid angles of its triangles over 4 pi (Van
  /// Oosterom and Strackee, The Solid Angle of a Plane Triangle, 1983).
  [[nodiscard]] double windingNumber(Vec3 point) const;
  /// To the nearest place of the surface (m).
  [[nodiscard]] double distanceTo(Vec3 point) const;
  /// The distance to the surface (m) of a point that the mesh winds around, 0 of others.
  [[nodiscard]] double depthInside(Vec3 point) const;

  [[nodiscard]] Vec3 low() const { return low_; }
  [[nodiscard]] Vec3 high() const { return high_; }

 private:
  std::vector<Vec3> vertices_;
  std::vector<TriangleIndices> triangles_;
  Vec3 low_, high_;
};

/// Farther inside than this (m) is inside: what the contact core keeps off a surface is more.
inline constexpr double kWithin_m = 30e-9;

/// Ticks in which an IHIP is inside a body. One that finds itself there is put out of it in the next tick: one tick alone
/// is told apart from several in a row.
class InsideTicks {
 public:
  void see(double depth_m);

  [[nodiscard]] int all() const { return all_; }
  [[nodiscard]] int longest() const { return longest_; }  ///< In a row.
  [[nodiscard]] int single() const { return single_; }    ///< Neither after nor before another one.
  [[nodiscard]] double deepest_m() const { return deepest_m_; }

 private:
  int all_ = 0;
  int row_ = 0;
  int longest_ = 0;
  int single_ = 0;
  double deepest_m_ = 0;
};

}  // namespace haptics::eval

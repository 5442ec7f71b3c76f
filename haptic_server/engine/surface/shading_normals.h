#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "haptic_server/engine/geometry/collision_mesh.h"
#include "haptic_server/engine/geometry/large_pages.h"

namespace haptics {

/// What force shading needs of a polygon: the normals at its corners, in one cache line. Object frame.
struct alignas(64) ShadingRecord {
  /// Row d holds coordinate d of the three corners' unit normals and, in its last place, the roundness of corner d.
  std::array<std::array<float, 4>, 3> rows;
  std::array<float, 3> hollowness;  ///< Of each corner.
  std::uint32_t flags;

  static constexpr std::uint32_t kSharpLine = 1;     ///< Shifted left by k: edge k stays sharp.
  static constexpr std::uint32_t kSharpVertex = 8;   ///< Shifted left by k: a sharp line ends at corner k.
  static constexpr std::uint32_t kNoNormals = 0x40;  ///< Its corners' normals say nothing.

  [[nodiscard]] Vec3 normal(int k) const noexcept {
    const auto i = static_cast<std::size_t>(k);
    return {rows[0][i], rows[1][i], rows[2][i]};
  }
  /// Largest curvature (1/m) that the normals tell of around corner k: 1 over the depth at which lines along them would
  /// meet; 0 where they spread.
  [[nodiscard]] float roundness(int k) const noexcept { return rows[static_cast<std::size_t>(k)][3]; }
  [[nodiscard]] bool sharpLine(int k) const noexcept { return (flags & (kSharpLine << k)) != 0; }
  [[nodiscard]] bool sharpVertex(int k) const noexcept { return (flags & (kSharpVertex << k)) != 0; }
  [[nodiscard]] bool hasNormals() const noexcept { return (flags & kNoNormals) == 0; }
};
static_assert(sizeof(ShadingRecord) == 64, "one cache line");

/// The vertex normals that force shading interpolates (paper 4.1), apart from the mesh so that an object without
/// shading pays no memory. A vertex on a sharp line has a normal for each side of it: shading is for artificial edges,
/// "turned off when the objects have natural edges". Immutable; built off the servo thread.
///
/// A vertex's normal is the mean of its polygons' weighted by sin(angle) / (product of the two edges' lengths), which is
/// exact for vertices on a sphere (N. Max, "Weights for Computing Vertex Normals from Facet Normals", 1999). Never used
/// to tell inside from outside: for that the angle-weighted normals of CollisionMesh are right.
class ShadingNormals {
 public:
  /// @param crease_rad  Lines whose polygons' normals differ by more stay sharp; boundaries always do.
  /// @param creases  Further sharp lines by their vertices, the mesh's canonical numbering, the smaller first, ascending.
  ShadingNormals(const CollisionMesh& surface, double crease_rad,
                 std::span<const std::array<std::uint32_t, 2>> creases);

  /// `t` as in CollisionMesh.
  [[nodiscard]] const ShadingRecord& operator[](std::uint32_t t) const noexcept { return records_[t]; }
  /// No bulge of the smooth surface over a polygon (ShadedPoint) is higher.
  [[nodiscard]] double highestBulge_m() const noexcept { return highestBulge_m_; }
  [[nodiscard]] std::size_t memory_bytes() const noexcept { return records_.capacity() * sizeof(ShadingRecord); }

 private:
  LargePageVector<ShadingRecord> records_;
  double highestBulge_m_ = 0;
};

}  // namespace haptics

#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "haptic_server/engine/geometry/collision_mesh.h"
#include "tests/eval/random.h"

namespace haptics::eval {

/// A mesh to be touched, and what would close it. Metres.
struct FuzzMesh {
  std::vector<Vec3f> vertices;
  std::vector<TriangleIndices> triangles;
  /// Of the same vertices. None where the mesh is closed; with them a sheet or a scan would be.
  std::vector<TriangleIndices> missing;
  /// Of a plate that is larger than where the HIP goes, so that nothing goes round it: so many triangles, the first ones, are
  /// its upper face. 0: it is no such plate.
  std::size_t upper = 0;
  /// As the server made it of another mesh; null: of the triangles.
  std::shared_ptr<const CollisionMesh> surface = nullptr;

  [[nodiscard]] bool closed() const { return missing.empty(); }
  /// Of `triangles`, vertices in their order, or `surface`.
  [[nodiscard]] std::shared_ptr<const CollisionMesh> build() const;
  [[nodiscard]] Vec3 middleOf(std::size_t triangle) const;
};

/// What would close these triangles: a cone over their boundary, to its middle, or, where the boundary is flat, to far below
/// that. Adds the middle to the vertices.
[[nodiscard]] std::vector<TriangleIndices> coneOverBoundary(std::vector<Vec3f>& vertices,
                                                            std::span<const TriangleIndices> triangles);

/// Does every edge join two triangles that run along it in opposite directions?
[[nodiscard]] bool isClosed(const std::vector<TriangleIndices>& triangles);

enum class MeshKind {
  kBox,
  kBlob,
  kSpiky,
  kFolded,    ///< Closed, and passes through itself.
  kSheet,     ///< A height field, larger than where the HIP goes.
  kScan,      ///< Closed but for some patches.
  kPlate,     ///< A sheet with a second face 1 um to 0.3 mm below it.
  kMirrored,  ///< One of the closed ones as the server has it under a lattice that mirrors it.
};

/// Some 10 to 70 mm large, but for sheets and plates, of 600 mm. All faces outward; a sheet faces up.
[[nodiscard]] FuzzMesh makeMesh(MeshKind kind, Random& random);

/// Standard normal distribution in every coordinate.
[[nodiscard]] Vec3 normalVector(Random& random);

}  // namespace haptics::eval

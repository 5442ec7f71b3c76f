#pragma once

#include <memory>
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

  [[nodiscard]] bool closed() const { return missing.empty(); }
  [[nodiscard]] std::shared_ptr<const CollisionMesh> build() const;  ///< Of `triangles`, vertices in their order.
  [[nodiscard]] Vec3 middleOf(std::size_t triangle) const;
};

/// Does every edge join two triangles that run along it in opposite directions?
[[nodiscard]] bool isClosed(const std::vector<TriangleIndices>& triangles);

enum class MeshKind {
  kBox,
  kBlob,
  kSpiky,
  kFolded,  ///< Closed, and passes through itself.
  kSheet,   ///< A height field, larger than where the HIP goes.
  kScan,    ///< Closed but for some patches.
};

/// Some 10 to 70 mm large, but for sheets, of 600 mm. All faces outward; a sheet faces up.
[[nodiscard]] FuzzMesh makeMesh(MeshKind kind, Random& random);

/// Standard normal distribution in every coordinate.
[[nodiscard]] Vec3 normalVector(Random& random);

}  // namespace haptics::eval

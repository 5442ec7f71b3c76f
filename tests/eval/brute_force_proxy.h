#pragma once

#include "common/mesh/tri_mesh.h"

namespace haptics::eval {

/// What the contact on one mesh should be, without hierarchy, neighbours or features: the point descends to ever closer
/// points of the triangles that it lies on, and each time all triangles of the mesh are asked whether it does. Follows
/// the path, as the proxy does: the globally closest point is another one where facets overlap below the surface.
class BruteForceProxy {
 public:
  explicit BruteForceProxy(const TriMesh& mesh);

  /// Starts at the point of the surface that is closest to `hip` (object frame, metres).
  void touch(Vec3 hip);
  /// Where the proxy comes to for the HIP's next place.
  Vec3 follow(Vec3 hip);

 private:
  [[nodiscard]] Vec3 closestOnThoseAt(Vec3 at, double within, Vec3 hip) const;

  std::vector<std::array<Vec3, 3>> triangles_;
  double tolerance_;  ///< Metres: what still counts as lying on a triangle.
  Vec3 proxy_{0};
};

}  // namespace haptics::eval

#pragma once

#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// Walks the polygons around a vertex (paper Figure 3a): calls visit(polygon, corner) for the others of the fan that
/// holds `triangle`, first one way round, then, when the fan is open, the other way. The lines of the vertex are the
/// edges corner and corner - 1 of those polygons. Stops when visit returns false.
template <class Visit>
void visitFan(const CollisionMesh& surface, std::uint32_t triangle, int corner, Visit visit) noexcept {
  const std::uint32_t apex = surface.triangle(triangle).vertexAt(corner);
  for (const bool forward : {true, false}) {
    std::uint32_t t = triangle;
    int k = corner;
    while (true) {
      t = surface.triangle(t).neighbour(forward ? previousCorner(k) : k);
      if (t == triangle) return;  // a closed fan: all of it was seen
      if (t == kNoTriangle) break;
      k = surface.triangle(t).cornerOf(apex);
      if (!visit(t, k)) return;
    }
  }
}

/// The edge of the polygon across line (triangle, edge) that is the same line, or -1 at a boundary.
[[nodiscard]] inline int sameLineAcross(const CollisionMesh& surface, std::uint32_t triangle, int edge) noexcept {
  const std::uint32_t across = surface.triangle(triangle).neighbour(edge);
  if (across == kNoTriangle) return -1;
  return surface.triangle(across).cornerOf(surface.triangle(triangle).vertexAt(nextCorner(edge)));
}

}  // namespace haptics

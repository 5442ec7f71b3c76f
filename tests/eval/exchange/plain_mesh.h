#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics::eval {

/// Vertices and triangles in the order in which a mesh was given. A vertex that no triangle has is the origin.
struct PlainMesh {
  explicit PlainMesh(const CollisionMesh& surface) : triangles(surface.triangleCount()) {
    for (std::uint32_t t = 0; t < surface.triangleCount(); ++t) {
      const TriangleRecord& record = surface.triangle(t);
      triangles[record.canonical()] = record.vertex;
      for (int k = 0; k < 3; ++k) {
        vertices.resize(std::max<std::size_t>(vertices.size(), record.vertexAt(k) + 1));
        vertices[record.vertexAt(k)] = Vec3f(record.corner(k));
      }
    }
  }
  std::vector<Vec3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

}  // namespace haptics::eval

#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh/tri_mesh.h"

namespace haptics {

/// A mesh prepared for smooth shading: vertices are repeated where the surface has a crease.
struct ShadedMesh {
  std::vector<std::uint32_t> source;       ///< Canonical vertex that each shaded vertex stands at.
  std::vector<Vec3f> normals;              ///< Unit, outward, object frame; one for each shaded vertex.
  std::vector<TriangleIndices> triangles;  ///< Canonical order and corner order, naming shaded vertices.
  bool closed = false;                     ///< Consistently oriented, without a boundary: no back side is ever seen.
};

/// Edges whose faces meet at a larger angle (radians) are drawn sharp: the box stays a box, the head stays smooth.
/// Smaller values facet coarse curved meshes, larger ones round off corners.
inline constexpr double kCreaseAngle_rad = 0.7;

/// Vertex normals as the angle-weighted mean of the faces that join smoothly at the vertex (Thürmer & Wüthrich 1998).
/// Two faces join where they share an edge at the vertex and their normals differ by at most `crease_rad`. Faces
/// without area take part with no weight; where nothing has area the normal is +z.
[[nodiscard]] ShadedMesh shadeMesh(const TriMesh& mesh, double crease_rad = kCreaseAngle_rad);

}  // namespace haptics

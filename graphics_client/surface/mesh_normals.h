#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "common/scene/surface_properties.h"

namespace haptics {

/// A mesh with a normal at each vertex: vertices are repeated where the surface has a crease.
struct ShadedMesh {
  std::vector<std::uint32_t> source;       ///< Canonical vertex that each shaded vertex stands at.
  std::vector<Vec3f> normals;              ///< Unit, outward, object frame; one for each shaded vertex.
  std::vector<TriangleIndices> triangles;  ///< Canonical order and corner order, naming shaded vertices.
};

/// Faces whose normals differ by less (radians) are one plane: what float32 vertices leave of a plane, and less than
/// neighbours on a sphere of ten million triangles differ by.
inline constexpr double kSamePlane_rad = 1e-4;

/// The vertex normals that force shading feels (haptic_server/engine/surface/shading_normals.h): at each vertex the mean of the
/// faces that join smoothly, weighted by sin(angle) / (product of the two edges' lengths), which is exact on a sphere
/// (N. Max, "Weights for Computing Vertex Normals from Facet Normals", 1999). Two faces join where they share an edge at
/// the vertex that is none of `creases`, and their normals differ by at most `crease_rad`. Where nothing has area the
/// normal is +z.
/// @param creases  By their vertices, the smaller first, ascending.
[[nodiscard]] ShadedMesh shadeMesh(const TriMesh& mesh, double crease_rad, std::span<const Crease> creases = {});

/// Consistently oriented, without a boundary: no back side is ever seen.
[[nodiscard]] bool isClosed(const TriMesh& mesh);

}  // namespace haptics

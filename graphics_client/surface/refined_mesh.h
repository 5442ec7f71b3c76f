#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "graphics_client/surface/mesh_normals.h"

namespace haptics {

/// A mesh whose triangles were cut finer, without moving its surface, to carry detail at its vertices. Object frame, m.
struct RefinedMesh {
  std::vector<Vec3> places;  ///< The mesh's vertices, then the middles of edges.
  /// The edge's ends, which come before it; one for each place after the mesh's vertices.
  std::vector<std::array<std::uint32_t, 2>> parents;
  std::vector<std::uint32_t> place;  ///< Of each drawn vertex: several stand at one place where there is a crease.
  std::vector<Vec3> normals;         ///< Of each drawn vertex: unit, by Eq. (1) of the paper.
  std::vector<TriangleIndices> triangles;  ///< Naming drawn vertices, oriented as the mesh's.
  std::vector<std::uint8_t> rims;          ///< Of each triangle, bit k: edge k is part of an edge of the mesh.
  double longestEdge_m = 0;                ///< After cutting.
};

/// Cuts the mesh's edges in half until none is longer than `longestEdge_m` (> 0), or as far as `maxTriangles` allow,
/// the longest first. Neighbours agree on each edge: no cracks.
[[nodiscard]] RefinedMesh refine(const TriMesh& mesh, const ShadedMesh& shaded, double longestEdge_m,
                                 std::size_t maxTriangles);

}  // namespace haptics

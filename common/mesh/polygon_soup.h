#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/maths/vec.h"
#include "common/mesh/tri_mesh.h"

namespace haptics {

/// What a file holds, before welding and scaling: triangles in the file's units, in the file's order, and what was left
/// out on the way here.
struct PolygonSoup {
  std::vector<Vec3> vertices;
  std::vector<TriangleIndices> triangles;
  std::uint64_t verticesInFile = 0;
  std::uint64_t polygonsTriangulated = 0;
  std::uint64_t degenerate = 0;  ///< Triangles that were not even taken over: fewer than three different corners.
  std::uint64_t outOfRange = 0;  ///< Triangles of polygons that name a vertex that is not there.
  std::uint64_t shapesSkipped = 0;
  std::uint64_t headerLinesSkipped = 0;
  std::uint64_t bytesAtEnd = 0;

  /// Cuts the polygon into triangles and appends them, each with the polygon's winding. A polygon that names a vertex
  /// that is not (yet) in `vertices` is counted instead.
  void addPolygon(std::span<const std::uint32_t> corners);
};

}  // namespace haptics

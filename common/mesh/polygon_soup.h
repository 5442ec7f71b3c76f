#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/maths/vec.h"
#include "common/mesh/tri_mesh.h"

namespace haptics {

/// What a file holds beside faces, and is not felt.
struct LeftOut {
  std::uint64_t points = 0, lines = 0;
  std::uint64_t skins = 0, morphs = 0;  ///< Meshes that a skeleton or targets move: they are as they are stored.
  std::uint64_t animations = 0;
  std::uint64_t unshown = 0;    ///< Meshes that the scene does not show: hidden, of another scene, or placed nowhere.
  std::uint64_t instances = 0;  ///< Copies of meshes that an extension places.
};

/// How far float32 may put a number of this size off.
[[nodiscard]] inline double float32Rounding(double size) {
  constexpr int kBits = 24;
  return size > 0 ? std::ldexp(1.0, std::ilogb(size) - kBits) : 0;
}

/// Content of a mesh file before welding and scaling: triangles in the file's units, in the file's order, and what was left
/// out on the way here.
struct PolygonSoup {
  std::vector<Vec3> vertices;
  std::vector<TriangleIndices> triangles;
  std::uint64_t polygonsTriangulated = 0;
  std::uint64_t polygonsCrossing = 0;  ///< Of those, outlines that cross themselves: some triangles face back.
  std::uint64_t degenerate = 0;        ///< Triangles that were not even taken over: fewer than three different corners.
  std::uint64_t outOfRange = 0;        ///< Triangles of polygons that name a vertex that is not there.
  std::uint64_t shapesSkipped = 0;
  std::uint64_t headerLinesSkipped = 0;
  std::uint64_t linesSkipped = 0;   ///< After the header: lines, or ends of lines, that the format does not have.
  std::uint64_t bytesAtEnd = 0;     ///< After the last face.
  std::uint64_t countsIgnored = 0;  ///< Numbers of triangles, because they are wrong.
  std::uint64_t meshesTaken =
      0;                         ///< Of a file of several: those that are in here, each as often as the file places it,
  std::uint64_t meshesLeft = 0;  ///< and those that were not asked for.
  std::string cutOff;  ///< Why it is refused unless the mesh is closed; empty: nothing says that it was cut off.
  LeftOut leftOut;
  std::optional<double> unit_m = std::nullopt;  ///< Metres, where the file says so.
  bool isFloat32 = false;                       ///< The file, or who reads it, holds its coordinates so.
  double rounding =
      0;  ///< Instead, where who reads it places them: how far float32 may have put one off, units of the file.

  /// For addPolygon(), of a file's number from 0: one that is not in `vertices` where it is not.
  [[nodiscard]] std::uint32_t numbered(std::int64_t vertex) const {
    const bool isThere = vertex >= 0 && vertex < static_cast<std::int64_t>(vertices.size());
    return isThere ? static_cast<std::uint32_t>(vertex) : std::numeric_limits<std::uint32_t>::max();
  }
  /// Cuts the polygon, of n corners, into n - 2 triangles and appends them, each with the polygon's winding: a hole is a
  /// part of the outline that a bridge, passed twice, leads to. About n log n for outlines from practice. A polygon that names a vertex
  /// that is not (yet) in `vertices` is counted instead.
  void addPolygon(std::span<const std::uint32_t> corners);
};

/// The outline of a polygon with holes, as PolygonSoup::addPolygon() takes it: joined by bridges. Its corners and those of the
/// holes, which run either way, are numbers of `places`. Takes the time of holes times corners.
[[nodiscard]] std::vector<std::uint32_t> joinedOutline(std::vector<std::uint32_t> outline,
                                                       std::vector<std::vector<std::uint32_t>> holes,
                                                       const std::vector<Vec3>& places);

}  // namespace haptics

#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "common/error/error.h"
#include "common/mesh/part_name.h"
#include "common/mesh/polygon_soup.h"
#include "common/mesh/self_intersection_repair.h"
#include "common/mesh/tri_mesh.h"

namespace haptics {

/// Faces around one vertex above which the contact search cannot look at all of them in one tick.
inline constexpr std::uint32_t kCrowdedValence = 3200;

/// Defects that import found in a file, and repairs. Counts are of triangles unless the name says otherwise.
struct MeshReport {
  std::uint64_t trianglesInFile = 0;  ///< After triangulating polygons.
  std::uint64_t kept = 0;
  std::uint64_t polygonsTriangulated = 0;  ///< Polygons of more than three corners, cut into triangles.
  std::uint64_t polygonsCrossing = 0;      ///< Of those, outlines that cross themselves: some triangles face back.
  std::uint64_t droppedDegenerate = 0;     ///< Two corners at one place, or no area.
  std::uint64_t droppedOutOfRange = 0;     ///< Naming a vertex that is not there.
  std::uint64_t duplicateFaces = 0;        ///< Same three vertices; kept.
  std::uint64_t verticesInFile = 0;
  std::uint64_t verticesWelded = 0;      ///< Merged into another at the same place.
  std::uint64_t verticesJoined = 0;      ///< Made one with another that only rounding kept apart: see joinOpenEdges().
  std::uint64_t verticesUnused = 0;      ///< Left out: no kept triangle names them.
  std::uint64_t shapesSkipped = 0;       ///< Of an Inventor file: see gatherInventor().
  std::uint64_t headerLinesSkipped = 0;  ///< PolygonSoup::headerLinesSkipped.
  std::uint64_t linesSkipped = 0;        ///< PolygonSoup::linesSkipped.
  std::uint64_t bytesAtEnd = 0;          ///< PolygonSoup::bytesAtEnd.
  std::uint64_t countsIgnored = 0;       ///< PolygonSoup::countsIgnored.
  std::uint64_t meshesTaken = 0;         ///< PolygonSoup::meshesTaken.
  std::uint64_t meshesLeft = 0;          ///< PolygonSoup::meshesLeft.
  LeftOut leftOut;                       ///< PolygonSoup::leftOut.
  std::uint64_t boundaryEdges = 0;       ///< One face.
  std::uint64_t tJunctions = 0;          ///< Boundary edges with a vertex of other boundary edges on them.
  std::uint64_t nonManifoldEdges = 0;    ///< More than two faces.
  std::uint64_t inconsistentEdges = 0;   ///< Two faces that run along it the same way: one is flipped.
  std::uint64_t closedParts = 0;         ///< Parts that no vertex joins with another one, and that have an inside.
  std::uint64_t insideOutParts = 0;   ///< Closed ones whose faces look inwards, and that are no hollow in another one.
  std::uint64_t slivers = 0;          ///< More than 1,000 times as long as high; kept.
  std::uint64_t crowdedVertices = 0;  ///< More than kCrowdedValence triangles around them.
  std::uint32_t maxValence = 0;       ///< Most triangles around one vertex.
  RepairReport repair;                ///< Of self-intersections.
  bool tJunctionsSearched = true;     ///< False: that would have taken too long; none are counted.
  double meanEdge_m = 0;
  Vec3 boxMin_m{0}, boxMax_m{0};  ///< After scaling.
  double scale_m = 1;             ///< Metres per file unit that was applied.
  bool isUnitKnown = false;       ///< The options or the file say it.
  double rounding_m = 0;  ///< How far float32 may have put a vertex from its place: in the mesh, and in the file.

  [[nodiscard]] bool closed() const noexcept { return boundaryEdges + nonManifoldEdges + inconsistentEdges == 0; }
  [[nodiscard]] double longestSide_m() const noexcept;
  /// "60 m large; did you mean unit_m: 0.001?", by likelyScale(); empty where the unit is known, or metres are likely.
  [[nodiscard]] std::string doubtOfUnit() const;
  /// One line for the log and for replies, naming everything that is not zero.
  [[nodiscard]] std::string text() const;
};

struct ImportOptions {
  std::optional<double> unit_m = std::nullopt;  ///< Metres per unit of the file; none: what the file says, else 1.
  /// Instead: scale so that the longest side has this length, centre at 0.
  std::optional<double> largestExtent_m = std::nullopt;
  bool keepCrossings = false;  ///< Leave a mesh that passes through itself as it is (importMesh() only).
  PartName part = {};          ///< Of a file of several meshes (readerOf() is kAssimp); empty: all of them, as one.
};

/// What to import a file with of which nobody says the unit, by its longest side in metres if it were in metres: nothing more
/// where that is at most kLargest_m, else the unit of millimetres where that makes it so, else the extent kScaledTo_m.
inline constexpr double kLargest_m = 1, kScaledTo_m = 0.1;
[[nodiscard]] std::optional<ImportOptions> likelyScale(double longestSide_m);

struct ImportedMesh {
  TriMesh mesh;
  MeshReport report;
  std::vector<std::uint32_t> source;  ///< Of each vertex, the first one at its place that was given.
};

enum class MeshFormat : std::uint8_t {
  kObj,
  kPly,
  kStl,
  kOff,
  kOm,
  kInventor,
  kGltf,
  kGlb,
  kCollada,
  k3mf,
  k3ds,
  kFbx,
  kX3d
};
/// Who reads a format: importMesh(), or the library that has a program of its own.
enum class MeshReader : std::uint8_t { kOwn, kCoin, kAssimp };
[[nodiscard]] MeshReader readerOf(MeshFormat format) noexcept;

/// By the ending of the file's name, in any case; before ".gz" if the file is packed.
[[nodiscard]] Result<MeshFormat> meshFormatOf(const std::filesystem::path& file);

/// A file's bytes in a format whose reader is kOwn: welds, drops what cannot be felt, scales, puts into canonical order,
/// repairs and reports. Nothing is dropped silently. In this process, for as long as it takes: see importMeshFile(). Refused:
/// unreadable, truncated, header claiming more than the file can hold, non-finite vertex, no triangle left.
[[nodiscard]] Result<ImportedMesh> importMesh(std::string_view file, MeshFormat format, const ImportOptions& options);
/// The same from what a file was found to hold.
[[nodiscard]] Result<ImportedMesh> importSoup(PolygonSoup soup, const ImportOptions& options);

/// Welding, scaling, canonical order and report for raw triangles in memory (units of the file): the second half of
/// importMesh(), and all of it for generated meshes. `verticesInFile` and `trianglesInFile` are taken from the arguments.
[[nodiscard]] Result<ImportedMesh> canonicalise(const std::vector<Vec3>& vertices,
                                                std::vector<TriangleIndices> triangles, const ImportOptions& options);

}  // namespace haptics

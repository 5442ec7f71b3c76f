#include "common/mesh/import.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "common/mesh/mesh_readers.h"
#include "common/mesh/text_scan.h"
#include "common/mesh/topology.h"

namespace haptics {
namespace {

struct FormatName {
  const char* ending;
  MeshFormat format;
};
constexpr std::array<FormatName, 20> kFormats{
    {{"obj", MeshFormat::kObj},      {"ply", MeshFormat::kPly},       {"stl", MeshFormat::kStl},
     {"off", MeshFormat::kOff},      {"om", MeshFormat::kOm},         {"iv", MeshFormat::kInventor},
     {"wrl", MeshFormat::kInventor}, {"vrml", MeshFormat::kInventor}, {"wrz", MeshFormat::kInventor},  // packed
     {"gltf", MeshFormat::kGltf},    {"glb", MeshFormat::kGlb},       {"dae", MeshFormat::kCollada},
     {"zae", MeshFormat::kCollada},  {"3mf", MeshFormat::k3mf},       {"3ds", MeshFormat::k3ds},
     {"fbx", MeshFormat::kFbx},      {"x3d", MeshFormat::kX3d},       {"x3dz", MeshFormat::kX3d},
     {"x3dv", MeshFormat::kX3d},     {"x3dvz", MeshFormat::kX3d}}};

Result<PolygonSoup> readSoup(std::string_view file, MeshFormat format) {
  switch (format) {
    case MeshFormat::kObj:
      return readObj(file);
    case MeshFormat::kPly:
      return readPly(file);
    case MeshFormat::kStl:
      return readStl(file);
    case MeshFormat::kOff:
      return readOff(file);
    case MeshFormat::kOm:
      return readOm(file);
    default:
      break;
  }
  return refused("", "is in a format that is not read here");
}

/// Of the largest coordinate, in units of the file.
double roundingOf(const PolygonSoup& soup) {
  double largest = 0;
  for (const TriangleIndices& triangle : soup.triangles) {
    for (const std::uint32_t v : triangle) {
      const Vec3 size = glm::abs(soup.vertices[v]);
      largest = std::max({largest, size.x, size.y, size.z});
    }
  }
  return float32Rounding(largest);
}

}  // namespace

Result<MeshFormat> meshFormatOf(const std::filesystem::path& file) {
  std::string ending = inLowerCase(file.extension().string());
  if (ending == ".gz") ending = inLowerCase(file.stem().extension().string());
  for (const FormatName& known : kFormats) {
    if (ending == std::string(".") + known.ending) return known.format;
  }
  return refused(
      "",
      "has an unknown format; the name should end in .obj, .ply, .stl, .off, .om, .iv, .wrl, .gltf, .glb, .dae, "
      ".zae, .3mf, .3ds, .fbx, .x3d or .x3dv, packed in .gz or not");
}

MeshReader readerOf(MeshFormat format) noexcept {
  if (format < MeshFormat::kInventor) return MeshReader::kOwn;
  return format == MeshFormat::kInventor ? MeshReader::kCoin : MeshReader::kAssimp;
}

Result<ImportedMesh> importMesh(std::string_view file, MeshFormat format, const ImportOptions& options) {
  return readSoup(file, format).and_then([&](PolygonSoup soup) { return importSoup(std::move(soup), options); });
}

Result<ImportedMesh> importSoup(PolygonSoup soup, const ImportOptions& options) {
  const std::uint64_t taken = soup.triangles.size();
  const std::uint64_t leftOut = soup.degenerate + soup.outOfRange;
  if (taken == 0 && leftOut > 0) {
    return refused("", "holds no usable triangle: " + std::to_string(soup.degenerate) + " are degenerate, " +
                           std::to_string(soup.outOfRange) + " name a vertex that is not there (of " +
                           std::to_string(soup.vertices.size()) + ')');
  }
  if (taken == 0 && soup.shapesSkipped > 0) {
    return refused("",
                   "holds nothing but " + std::to_string(soup.shapesSkipped) +
                       " parts that are not read: NURBS, splines, texts, lines, points, unknown nodes, or meshes and "
                       "files that are not there, or not below its folder");
  }
  const LeftOut& left = soup.leftOut;
  if (taken == 0 && left.points + left.lines > 0) {
    return refused("", "holds no face: nothing but " + std::to_string(left.points) + " points and " +
                           std::to_string(left.lines) + " lines, which cannot be felt");
  }
  const double rounding = soup.isFloat32 ? roundingOf(soup) : soup.rounding;
  ImportOptions scaling = options;
  if (!scaling.unit_m && !scaling.largestExtent_m) scaling.unit_m = soup.unit_m;
  auto imported = canonicalise(soup.vertices, std::move(soup.triangles), scaling);
  if (!imported) return imported;
  MeshReport& report = imported->report;
  if (!soup.cutOff.empty() && !report.closed()) return refused("", soup.cutOff);
  report.rounding_m = std::max(report.rounding_m, rounding * report.scale_m);
  report.trianglesInFile += leftOut;
  report.droppedDegenerate += soup.degenerate;
  report.droppedOutOfRange += soup.outOfRange;
  report.polygonsTriangulated = soup.polygonsTriangulated;
  report.polygonsCrossing = soup.polygonsCrossing;
  report.shapesSkipped = soup.shapesSkipped;
  report.meshesTaken = soup.meshesTaken;
  report.meshesLeft = soup.meshesLeft;
  report.leftOut = soup.leftOut;
  report.headerLinesSkipped = soup.headerLinesSkipped;
  report.linesSkipped = soup.linesSkipped;
  report.bytesAtEnd = soup.bytesAtEnd;
  report.countsIgnored = soup.countsIgnored;
  const double farthest_m = options.keepCrossings ? 0 : kMaxRepairDistance * report.longestSide_m();
  report.repair = repairSelfIntersections(imported->mesh, report.closed(), farthest_m);
  if (report.repair.trianglesCut > 0) {
    report.kept = imported->mesh.triangles.size();
    describeTopology(imported->mesh, report);
  }
  return imported;
}

}  // namespace haptics

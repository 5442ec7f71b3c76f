#include "common/mesh/import.h"

#include <algorithm>
#include <cctype>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include "common/mesh/file_bytes.h"
#include "common/mesh/inventor_reader.h"
#include "common/mesh/openmesh_reader.h"
#include "common/mesh/plain_file.h"
#include "common/mesh/topology.h"

namespace haptics {
namespace {

std::string formatOf(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension.empty() ? extension : extension.substr(1);
}

using PlainMaker = Result<PlainFile> (*)(std::string_view);

PlainMaker plainMakerFor(const std::string& format) {
  if (format == "obj") return plainObj;
  if (format == "off") return plainOff;
  if (format == "ply") return plainPly;
  if (format == "stl") return plainStl;
  if (format == "om") return plainOm;
  return nullptr;
}

Result<PolygonSoup> readSoup(const std::filesystem::path& file) {
  const std::string format = formatOf(file);
  const PlainMaker makePlain = plainMakerFor(format);
  if (makePlain == nullptr && format != "iv") {
    return refused("", "has an unknown format; the name should end in .obj, .ply, .stl, .off, .om or .iv");
  }
  if (format == "iv") return readInventor(file);
  const auto bytes = readFile(file);
  if (!bytes) return tl::unexpected(bytes.error());
  return makePlain(*bytes).and_then([&format](PlainFile plain) { return readWithOpenMesh(std::move(plain), format); });
}

Result<ImportedMesh> importSoup(const std::filesystem::path& file, const ImportOptions& options) {
  auto soup = readSoup(file);
  if (!soup) return tl::unexpected(std::move(soup).error());
  const std::uint64_t taken = soup->triangles.size();
  const std::uint64_t leftOut = soup->degenerate + soup->outOfRange;
  const std::uint64_t joined = soup->verticesInFile - soup->vertices.size();  // by OpenMesh's STL reader
  if (taken == 0 && leftOut > 0) {
    return refused("", "holds no usable triangle: " + std::to_string(soup->degenerate) + " are degenerate, " +
                           std::to_string(soup->outOfRange) + " name a vertex that is not there (of " +
                           std::to_string(soup->verticesInFile) + ')');
  }
  if (taken == 0 && soup->shapesSkipped > 0) {
    return refused("", "holds nothing but NURBS shapes or files that are not beside it, which are not read");
  }
  auto imported = canonicalise(soup->vertices, std::move(soup->triangles), options);
  if (!imported) return imported;
  MeshReport& report = imported->report;
  report.verticesInFile += joined;
  report.verticesWelded += joined;
  report.trianglesInFile += leftOut;
  report.droppedDegenerate += soup->degenerate;
  report.droppedOutOfRange += soup->outOfRange;
  report.polygonsTriangulated = soup->polygonsTriangulated;
  report.shapesSkipped = soup->shapesSkipped;
  const Vec3 size_m = report.boxMax_m - report.boxMin_m;
  const double farthest_m = options.keepCrossings ? 0 : kFarthestMend * std::max({size_m.x, size_m.y, size_m.z});
  report.mended = mend(imported->mesh, report.closed(), farthest_m);
  if (report.mended.trianglesCut > 0) {
    report.kept = imported->mesh.triangles.size();
    describeTopology(imported->mesh, report);
  }
  return imported;
}

}  // namespace

Result<ImportedMesh> importMesh(const std::filesystem::path& file, const ImportOptions& options) {
  Result<ImportedMesh> imported;
  try {
    imported = importSoup(file, options);
  } catch (const std::bad_alloc&) {
    imported = refused("", "needs more memory than there is");
  } catch (const std::length_error&) {
    imported = refused("", "needs more memory than there is");
  } catch (const std::system_error& error) {
    imported = refused("", std::string("cannot be read: ") + error.what());
  }
  if (!imported && imported.error().field.empty()) return refused(file.string(), std::move(imported).error().reason);
  return imported;
}

}  // namespace haptics

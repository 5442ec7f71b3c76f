#include "haptic_server/scene/mesh_library.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <system_error>
#include <utility>
#include <variant>

#include "common/mesh/generators.h"
#include "common/mesh/import.h"

namespace haptics {
namespace fs = std::filesystem;
namespace {

struct Generated {
  const char* field;
  Result<TriMesh> mesh;
};

Generated generate(const MeshSource& source) {
  if (const auto* s = std::get_if<BoxSource>(&source.source)) return {"box.", makeBox(s->size_m, s->segments)};
  if (const auto* s = std::get_if<SphereSource>(&source.source))
    return {"sphere.", makeSphere(s->radius_m, s->segments)};
  if (const auto* s = std::get_if<CylinderSource>(&source.source)) {
    return {"cylinder.", makeCylinder(s->radius_m, s->height_m, s->segments)};
  }
  const auto& s = std::get<TorusSource>(source.source);
  return {"torus.", makeTorus(s.majorRadius_m, s.minorRadius_m, s.majorSegments, s.minorSegments)};
}

}  // namespace

Result<ResolvedMesh> MeshLibrary::resolve(const MeshSource& source) {
  if (const auto* file = std::get_if<FileSource>(&source.source)) return fromFile(source, *file);
  if (source.largestExtent_m) return refused("largest_extent_m", "only a mesh from a file is scaled; leave it out");
  if (source.unit_m != 1) return refused("unit_m", "only a mesh from a file has a unit; leave it out");
  if (const auto* asset = std::get_if<AssetSource>(&source.source)) return fromStore(*asset);
  return generated(source);
}

Result<ResolvedMesh> MeshLibrary::fromFile(const MeshSource& source, const FileSource& file) {
  auto located = folders_.locate(file.path, "file");
  if (!located) return tl::unexpected(std::move(located).error());
  std::error_code error;
  const FileKey key{located->string(),
                    fs::last_write_time(*located, error),
                    fs::file_size(*located, error),
                    source.unit_m,
                    source.largestExtent_m,
                    source.keepCrossings};
  if (const auto at = imported_.find(key); at != imported_.end()) {
    if (auto asset = at->second.asset.lock()) return ResolvedMesh{std::move(asset), at->second.report};
  }
  auto imported = importMesh(
      *located,
      {.unit_m = source.unit_m, .largestExtent_m = source.largestExtent_m, .keepCrossings = source.keepCrossings});
  if (!imported) return refused("file", seenFromOutside(imported.error().text(), *located, file.path));

  ResolvedMesh resolved{store_.intern(std::move(imported->mesh)), file.path + ": " + imported->report.text()};
  std::erase_if(imported_, [](const auto& entry) { return entry.second.asset.expired(); });
  imported_.insert_or_assign(key, Imported{resolved.asset, resolved.report});
  return resolved;
}

Result<ResolvedMesh> MeshLibrary::fromStore(const AssetSource& source) const {
  auto asset = as<MeshAsset>(store_.find(source.hash));
  if (!asset) return refused("asset", "no mesh " + source.hash.hex() + " is here; upload it in this session first");
  return ResolvedMesh{std::move(asset), "a mesh that the server held"};
}

Result<ResolvedMesh> MeshLibrary::generated(const MeshSource& source) {
  auto made = generate(source);
  if (!made.mesh) return tl::unexpected(std::move(made.mesh).error().within(made.field));
  std::string report = "generated, " + std::to_string(made.mesh->triangles.size()) + " triangles";
  return ResolvedMesh{store_.intern(*std::move(made.mesh)), std::move(report)};
}

}  // namespace haptics

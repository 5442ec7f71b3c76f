#include "haptic_server/scene/mesh_library.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <system_error>
#include <type_traits>
#include <utility>
#include <variant>

#include "common/importer/importer.h"
#include "common/interruption/interruption.h"
#include "common/interruption/progress.h"
#include "haptic_server/scene/scene_limits.h"
#include "haptic_server/simplification/simplify.h"

namespace haptics {
namespace fs = std::filesystem;
namespace {

/// Triangles of a generated mesh above which it is made in a process of its own; making so many takes 50 ms.
constexpr double kMaxMadeHere = 100'000;

/// "0.83".
std::string errorText(double error_jnd) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", error_jnd);
  return text.data();
}

}  // namespace

std::optional<MeshRecipe> recipeOf(const MeshSource& source) {
  return std::visit(
      [](const auto& chosen) -> std::optional<MeshRecipe> {
        if constexpr (std::is_constructible_v<MeshRecipe, decltype(chosen)>) return chosen;
        return std::nullopt;
      },
      source.source);
}

double trianglesMadeFor(const MeshSource& source) {
  if (std::holds_alternative<FileSource>(source.source)) return std::numeric_limits<double>::infinity();
  const auto recipe = recipeOf(source);
  return recipe ? trianglesOf(*recipe) : 0;
}

template <class Key>
std::optional<ResolvedMesh> MeshLibrary::known(const std::map<Key, Imported>& meshes, const Key& key) {
  const std::lock_guard lock(mutex_);
  const auto at = meshes.find(key);
  auto asset = at == meshes.end() ? nullptr : at->second.asset.lock();
  if (!asset) return std::nullopt;
  return ResolvedMesh{std::move(asset), at->second.report};
}

template <class Key>
void MeshLibrary::keep(std::map<Key, Imported>& meshes, const Key& key, const ResolvedMesh& mesh) {
  const std::lock_guard lock(mutex_);
  std::erase_if(meshes, [](const auto& entry) { return entry.second.asset.expired(); });
  meshes.insert_or_assign(key, Imported{mesh.asset, mesh.report});
}

Result<ResolvedMesh> MeshLibrary::resolve(const MeshSource& source, double stiffness_N_per_m) {
  return source.simplifyError ? simplified(source, stiffness_N_per_m) : unsimplified(source);
}

Result<ResolvedMesh> MeshLibrary::simplified(const MeshSource& source, double stiffness_N_per_m) {
  std::optional<SimplifiedKey> key;
  if (const auto* file = std::get_if<FileSource>(&source.source)) {
    auto fileKey = keyOf(source, *file);
    if (!fileKey) return tl::unexpected(std::move(fileKey).error());
    key.emplace(*std::move(fileKey), *source.simplifyError, stiffness_N_per_m);
    if (auto mesh = known(simplified_, *key)) return *std::move(mesh);
  }
  auto mesh = unsimplified(source);
  if (!mesh) return mesh;
  if (auto ok = checkSimplifiable(*mesh->asset->surface, stiffness_N_per_m); !ok)
    return tl::unexpected(std::move(ok).error());
  reportProgress(WorkStage::kMaking, 0);
  const TriMesh& all = *mesh->asset->mesh;
  auto simpler = simplify(all, *mesh->asset->surface, *source.simplifyError, stiffness_N_per_m);
  const auto number = [](auto value) { return std::to_string(value); };
  if (simpler) {
    mesh->report += "; simplified from " + number(all.triangles.size()) + " triangles to " +
                    number(simpler->mesh.triangles.size()) + ", force error " + errorText(simpler->error_jnd) + " of " +
                    errorText(*source.simplifyError);
    mesh->asset = store_.intern(std::move(simpler->mesh), std::move(simpler->surface));
  } else {
    mesh->report += "; not simplified: with fewer than its " + number(all.triangles.size()) +
                    " triangles the force error is not below " + errorText(*source.simplifyError);
  }
  if (key) keep(simplified_, *key, *mesh);
  return mesh;
}

Result<ResolvedMesh> MeshLibrary::unsimplified(const MeshSource& source) {
  if (const auto* file = std::get_if<FileSource>(&source.source)) return fromFile(source, *file);
  if (source.largestExtent_m) return refused("largest_extent_m", "only a mesh from a file is scaled; leave it out");
  if (source.unit_m) return refused("unit_m", "only a mesh from a file has a unit; leave it out");
  if (const auto* asset = std::get_if<AssetSource>(&source.source)) return fromStore(*asset);
  return generated(source);
}

Result<MeshLibrary::FileKey> MeshLibrary::keyOf(const MeshSource& source, const FileSource& file) const {
  return folders_.locate(file.path, "file").map([&](const LocatedFile& located) {
    std::error_code error;
    return FileKey{located.file.string(),
                   fs::last_write_time(located.file, error),
                   fs::file_size(located.file, error),
                   source.unit_m,
                   source.largestExtent_m,
                   source.keepCrossings,
                   source.part};
  });
}

Result<ResolvedMesh> MeshLibrary::fromFile(const MeshSource& source, const FileSource& file) {
  auto located = folders_.locate(file.path, "file");
  if (!located) return tl::unexpected(std::move(located).error());
  const auto key = keyOf(source, file);
  if (!key) return tl::unexpected(key.error());
  if (auto mesh = known(imported_, *key)) return *std::move(mesh);
  reportProgress(WorkStage::kMaking, 0);
  auto imported = importMeshFile(located->file, located->folder,
                                 {.unit_m = source.unit_m,
                                  .largestExtent_m = source.largestExtent_m,
                                  .keepCrossings = source.keepCrossings,
                                  .part = source.part},
                                 Interruptible::token());
  if (!imported) return refused("file", seenFromOutside(imported.error().text(), located->file, file.path));
  auto mesh = fromImporterProcess(std::move(imported->bytes));
  if (!mesh) return refused("file", file.path + ": " + mesh.error().text());

  ResolvedMesh resolved{*std::move(mesh), file.path + ": " + imported->report.text()};
  keep(imported_, *key, resolved);
  return resolved;
}

Result<ResolvedMesh> MeshLibrary::fromStore(const AssetSource& source) const {
  auto asset = as<MeshAsset>(store_.find(source.hash));
  if (!asset) return refused("asset", "no mesh " + source.hash.hex() + " is here; upload it in this session first");
  return ResolvedMesh{std::move(asset), "a mesh that the server held"};
}

Result<ResolvedMesh> MeshLibrary::generated(const MeshSource& source) {
  const MeshRecipe recipe = *recipeOf(source);
  Result<std::shared_ptr<const MeshAsset>> mesh;
  if (trianglesOf(recipe) > kMaxMadeHere) {
    reportProgress(WorkStage::kMaking, 0);
    mesh = makeInImporterProcess(recipe, Interruptible::token()).and_then([this](std::string bytes) {
      return fromImporterProcess(std::move(bytes));
    });
  } else {
    mesh = generate(recipe).map([this](TriMesh made) { return store_.intern(std::move(made)); });
  }
  if (!mesh) return tl::unexpected(std::move(mesh).error());
  std::string report = "generated, " + std::to_string((*mesh)->mesh->triangles.size()) + " triangles";
  return ResolvedMesh{*std::move(mesh), std::move(report)};
}

Result<std::shared_ptr<const MeshAsset>> MeshLibrary::fromImporterProcess(std::string bytes) {
  if (bytes.size() > SceneLimits{}.assets_bytes) {
    return refused("", "is a mesh of " + std::to_string(bytes.size()) + " bytes; all assets of a scene take at most " +
                           std::to_string(SceneLimits{}.assets_bytes));
  }
  return store_.internEncoded(AssetKind::kMesh, std::move(bytes)).map(as<MeshAsset>);
}

}  // namespace haptics

#include "haptic_server/scene/mesh_library.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "common/importer/importer.h"
#include "common/interruption/interruption.h"
#include "common/interruption/progress.h"
#include "haptic_server/scene/scene_limits.h"
#include "haptic_server/simplification/simplify.h"

namespace haptics {
namespace {

/// Triangles of a generated mesh above which it is made in a process of its own; making so many takes 50 ms.
constexpr double kMaxMadeHere = 100'000;

/// Fields of a source, beside the file, that an import may refuse.
constexpr std::array<std::string_view, 3> kImportOptions{"unit_m", "largest_extent_m", "part"};

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
std::optional<MeshLibrary::FromFile> MeshLibrary::known(const std::map<Key, Imported>& meshes, const Key& key) {
  std::optional<FromFile> found;
  {
    const std::lock_guard lock(mutex_);
    const auto at = meshes.find(key);
    if (at == meshes.end()) return std::nullopt;
    found = FromFile{{at->second.asset.lock(), at->second.report}, at->second.included};
  }
  const auto isAsItWas = [](const FileStamp& then) { return stampOf(then.file) == then; };
  return found->mesh.asset && std::ranges::all_of(found->included, isAsItWas) ? found : std::nullopt;
}

template <class Key>
void MeshLibrary::keep(std::map<Key, Imported>& meshes, const Key& key, const FromFile& made) {
  const std::lock_guard lock(mutex_);
  std::erase_if(meshes, [](const auto& entry) { return entry.second.asset.expired(); });
  meshes.insert_or_assign(key, Imported{made.mesh.asset, made.mesh.report, made.included});
}

Result<ResolvedMesh> MeshLibrary::resolve(const MeshSource& source, double stiffness_N_per_m) {
  if (source.simplifyError) return simplified(source, stiffness_N_per_m);
  return unsimplified(source).map([](FromFile&& made) { return std::move(made.mesh); });
}

Result<ResolvedMesh> MeshLibrary::simplified(const MeshSource& source, double stiffness_N_per_m) {
  std::optional<SimplifiedKey> key;
  if (const auto* file = std::get_if<FileSource>(&source.source)) {
    auto fileKey = keyOf(source, *file);
    if (!fileKey) return tl::unexpected(std::move(fileKey).error());
    key.emplace(*std::move(fileKey), *source.simplifyError, stiffness_N_per_m);
    if (auto made = known(simplified_, *key)) return std::move(made->mesh);
  }
  auto made = unsimplified(source);
  if (!made) return tl::unexpected(std::move(made).error());
  ResolvedMesh& mesh = made->mesh;
  if (auto ok = checkSimplifiable(*mesh.asset->surface, stiffness_N_per_m); !ok)
    return tl::unexpected(std::move(ok).error());
  reportProgress(WorkStage::kMaking, 0);
  const TriMesh& all = *mesh.asset->mesh;
  auto simpler = simplify(all, *mesh.asset->surface, *source.simplifyError, stiffness_N_per_m);
  const auto number = [](auto value) { return std::to_string(value); };
  if (simpler) {
    mesh.report += "; simplified from " + number(all.triangles.size()) + " triangles to " +
                   number(simpler->mesh.triangles.size()) + ", force error " + errorText(simpler->error_jnd) + " of " +
                   errorText(*source.simplifyError);
    mesh.asset = store_.intern(std::move(simpler->mesh), std::move(simpler->surface));
  } else {
    mesh.report += "; not simplified: with fewer than its " + number(all.triangles.size()) +
                   " triangles the force error is not below " + errorText(*source.simplifyError);
  }
  if (key) keep(simplified_, *key, *made);
  return std::move(mesh);
}

Result<MeshLibrary::FromFile> MeshLibrary::unsimplified(const MeshSource& source) {
  if (const auto* file = std::get_if<FileSource>(&source.source)) return fromFile(source, *file);
  if (source.largestExtent_m) return refused("largest_extent_m", "only a mesh from a file is scaled; leave it out");
  if (source.unit_m) return refused("unit_m", "only a mesh from a file has a unit; leave it out");
  const auto* asset = std::get_if<AssetSource>(&source.source);
  return (asset != nullptr ? fromStore(*asset) : generated(source)).map([](ResolvedMesh&& mesh) {
    return FromFile{std::move(mesh)};
  });
}

Result<MeshLibrary::FileKey> MeshLibrary::keyOf(const MeshSource& source, const FileSource& file) const {
  return folders_.locate(file.path, "file").map([&](const LocatedFile& located) {
    return FileKey{stampOf(located.file), source.unit_m, source.largestExtent_m, source.keepCrossings, source.part};
  });
}

Result<MeshLibrary::FromFile> MeshLibrary::fromFile(const MeshSource& source, const FileSource& file) {
  auto located = folders_.locate(file.path, "file");
  if (!located) return tl::unexpected(std::move(located).error());
  const auto key = keyOf(source, file);
  if (!key) return tl::unexpected(key.error());
  if (auto made = known(imported_, *key)) return *std::move(made);
  reportProgress(WorkStage::kMaking, 0);
  auto imported = importMeshFile(located->file, located->folder,
                                 {.unit_m = source.unit_m,
                                  .largestExtent_m = source.largestExtent_m,
                                  .keepCrossings = source.keepCrossings,
                                  .part = source.part},
                                 Interruptible::token());
  if (!imported) {
    const auto& [field, reason] = imported.error();
    if (std::ranges::count(kImportOptions, field) > 0)
      return refused(field, seenFromOutside(reason, located->file, file.path));
    return refused("file", seenFromOutside(imported.error().text(), located->file, file.path));
  }
  auto mesh = fromImporterProcess(std::move(imported->bytes));
  if (!mesh) return refused("file", file.path + ": " + mesh.error().text());

  FromFile made{{*std::move(mesh), file.path + ": " + imported->report.text()}, std::move(imported->included)};
  keep(imported_, *key, made);
  return made;
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

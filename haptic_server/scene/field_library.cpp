#include "haptic_server/scene/field_library.h"

#include <system_error>
#include <utility>

#include "common/importer/importer.h"
#include "common/interruption/interruption.h"
#include "common/interruption/progress.h"
#include "common/mesh/file_bytes.h"
#include "common/surface/makers/spot_noise.h"

namespace haptics {
namespace fs = std::filesystem;
namespace {

/// With what was done and how many samples came of it.
Resolved<FieldAsset> withSize(const std::shared_ptr<const FieldAsset>& asset, const std::string& done) {
  const SampledField& field = *asset->field;
  return {asset, done + std::to_string(field.width()) + " x " + std::to_string(field.height()) + " samples"};
}

}  // namespace

Result<Resolved<FieldAsset>> FieldLibrary::resolve(const FieldSource& source) {
  return std::visit([this](const auto& chosen) { return from(chosen); }, source);
}

Result<Resolved<VertexValuesAsset>> FieldLibrary::resolve(const VertexValuesSource& source) {
  if (const auto* inlined = std::get_if<GivenValues>(&source)) {
    return Resolved<VertexValuesAsset>{store_.intern(inlined->values),
                                       std::to_string(inlined->values.size()) + " vertex values"};
  }
  if (const auto* file = std::get_if<FileSource>(&source)) {
    return fromAssetFile<VertexValuesAsset>(*file).map([&](auto asset) {
      return Resolved<VertexValuesAsset>{asset,
                                         file->path + ": " + std::to_string(asset->values->size()) + " vertex values"};
    });
  }
  const ContentHash& hash = std::get<AssetSource>(source).hash;
  auto asset = as<VertexValuesAsset>(store_.find(hash));
  if (!asset)
    return refused("asset", "no vertex values " + hash.hex() + " are here; upload them in this session first");
  return Resolved<VertexValuesAsset>{std::move(asset), "vertex values that the server held"};
}

Result<Resolved<MovedVerticesAsset>> FieldLibrary::resolve(const ResidueSource& source) const {
  if (const auto* file = std::get_if<FileSource>(&source)) {
    return fromAssetFile<MovedVerticesAsset>(*file).map([&](auto asset) {
      return Resolved<MovedVerticesAsset>{
          asset, file->path + ": " + std::to_string(asset->moved->vertex.size()) + " moved vertices"};
    });
  }
  const ContentHash& hash = std::get<AssetSource>(source).hash;
  auto asset = as<MovedVerticesAsset>(store_.find(hash));
  if (!asset)
    return refused("asset", "no moved vertices " + hash.hex() + " are here; upload them in this session first");
  return Resolved<MovedVerticesAsset>{std::move(asset), ""};
}

Result<Resolved<PointFieldAsset>> FieldLibrary::resolve(const PointFieldSource& source, const MeshAsset& mesh) {
  if (const auto* held = std::get_if<AssetSource>(&source)) {
    auto asset = as<PointFieldAsset>(store_.find(held->hash));
    if (!asset)
      return refused("asset", "no point field " + held->hash.hex() + " is here; upload it in this session first");
    return Resolved<PointFieldAsset>{std::move(asset), "a point field that the server held"};
  }
  if (const auto* file = std::get_if<FileSource>(&source)) {
    return fromAssetFile<PointFieldAsset>(*file).map([&](auto asset) {
      return Resolved<PointFieldAsset>{asset,
                                       file->path + ": " + std::to_string(asset->field->samples().size()) + " samples"};
    });
  }
  const auto& recipe = std::get<GrownReactionDiffusionSource>(source);
  auto asset = once(grown_, GrownKey(recipe, mesh.name.hash), [&] {
    return fromImporterProcess<PointFieldAsset>(makeInImporterProcess(recipe, *mesh.mesh, Interruptible::token()));
  });
  if (!asset) return tl::unexpected<Error>(std::move(asset).error());
  return Resolved<PointFieldAsset>{*asset, "grown on the mesh by reaction and diffusion, " +
                                               std::to_string((*asset)->field->samples().size()) + " samples"};
}

template <class K, class Kind, class Make>
Result<std::shared_ptr<const Kind>> FieldLibrary::once(Made<K, Kind>& made, const K& key, Make make) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto at = made.find(key); at != made.end()) {
      if (auto asset = at->second.lock()) return asset;
    }
  }
  reportProgress(WorkStage::kMaking, 0);
  Result<std::shared_ptr<const Kind>> asset = make();
  if (!asset) return asset;
  const std::lock_guard lock(mutex_);
  std::erase_if(made, [](const auto& entry) { return entry.second.expired(); });
  made.insert_or_assign(key, *asset);
  return asset;
}

template <class Kind>
Result<std::shared_ptr<const Kind>> FieldLibrary::fromImporterProcess(Result<std::string> bytes) const {
  return std::move(bytes)
      .and_then([this](std::string read) { return store_.internEncoded(Kind::kKind, std::move(read)); })
      .map(as<Kind>);
}

template <class Kind>
Result<std::shared_ptr<const Kind>> FieldLibrary::fromAssetFile(const FileSource& file) const {
  const auto located = folders_.locate(file.path, "file");
  if (!located) return tl::unexpected<Error>(located.error());
  auto asset = fromImporterProcess<Kind>(readAssetFile(located->file));
  if (!asset) return refused("file", file.path + ": " + asset.error().text());
  return asset;
}

Result<Resolved<FieldAsset>> FieldLibrary::from(const FileSource& file) {
  auto located = folders_.locate(file.path, "image");
  if (!located) return tl::unexpected<Error>(std::move(located).error());
  std::error_code error;
  const fs::path& path = located->file;
  const ImageKey key{path.string(), fs::last_write_time(path, error), fs::file_size(path, error)};
  auto asset =
      once(made_, Key(key), [&] { return fromImporterProcess<FieldAsset>(importImage(path, Interruptible::token())); });
  if (!asset) return refused("image", seenFromOutside(asset.error().text(), path, file.path));
  return withSize(*asset, file.path + ": ");
}

Result<Resolved<FieldAsset>> FieldLibrary::from(const AssetSource& source) const {
  auto asset = as<FieldAsset>(store_.find(source.hash));
  if (!asset) return refused("asset", "no field " + source.hash.hex() + " is here; upload it in this session first");
  return Resolved<FieldAsset>{std::move(asset), "a field that the server held"};
}

Result<Resolved<FieldAsset>> FieldLibrary::from(const ReactionDiffusionSource& recipe) {
  const auto make = [&] {
    return fromImporterProcess<FieldAsset>(makeInImporterProcess(recipe, Interruptible::token()));
  };
  return once(made_, Key(recipe), make).map([](const auto& asset) {
    return withSize(asset, "computed by reaction and diffusion, ");
  });
}

Result<Resolved<FieldAsset>> FieldLibrary::from(const SpotNoiseSource& recipe) {
  const auto make = [&] { return store_.intern(spotNoise(recipe)); };
  return once(made_, Key(recipe), make).map([](const auto& asset) {
    return withSize(asset, "computed as spot noise, ");
  });
}

}  // namespace haptics

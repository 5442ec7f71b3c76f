#include "haptic_server/scene/asset_store.h"

#include <cstddef>
#include <span>
#include <utility>

#include "common/mesh/mesh_asset.h"

namespace haptics {

std::shared_ptr<const MeshAsset> AssetStore::intern(TriMesh mesh) {
  const ContentHash hash = hashOf(mesh);
  if (auto known = find(hash)) return known;
  std::string encoded = encodeMesh(mesh);
  return build(std::move(mesh), std::move(encoded), hash);
}

Result<std::shared_ptr<const MeshAsset>> AssetStore::internEncoded(const ContentHash& hash, std::string bytes) {
  if (auto known = find(hash)) return known;
  const ContentHash actual = Hasher().add(std::as_bytes(std::span(bytes))).finish();
  if (actual != hash) {
    return refused("hash", "the bytes hash to " + actual.hex() + ", declared was " + hash.hex());
  }
  auto mesh = decodeMesh(bytes);
  if (!mesh) return refused("data", mesh.error().text());
  return build(*std::move(mesh), std::move(bytes), hash);
}

std::shared_ptr<const MeshAsset> AssetStore::build(TriMesh mesh, std::string encoded, const ContentHash& hash) {
  auto asset = std::make_shared<MeshAsset>();
  asset->hash = hash;
  asset->surface = buildSurface(mesh.vertices, mesh.triangles);
  asset->mesh = std::make_shared<const TriMesh>(std::move(mesh));
  asset->encoded = std::make_shared<const std::string>(std::move(encoded));

  const std::lock_guard lock(mutex_);
  std::erase_if(assets_, [](const auto& entry) { return entry.second.expired(); });
  assets_[hash] = asset;
  return asset;
}

std::shared_ptr<const MeshAsset> AssetStore::find(const ContentHash& hash) const {
  const std::lock_guard lock(mutex_);
  const auto at = assets_.find(hash);
  return at == assets_.end() ? nullptr : at->second.lock();
}

std::size_t AssetStore::size() const {
  const std::lock_guard lock(mutex_);
  std::size_t alive = 0;
  for (const auto& [hash, asset] : assets_) alive += asset.expired() ? 0 : 1;
  return alive;
}

}  // namespace haptics

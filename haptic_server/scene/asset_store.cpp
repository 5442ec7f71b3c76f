#include "haptic_server/scene/asset_store.h"

#include <cstddef>
#include <span>

#include "common/mesh/mesh_asset.h"
#include "common/mesh/vertex_values.h"
#include "common/surface/field_asset.h"

namespace haptics {
namespace {

ContentHash hashOfBytes(const std::string& bytes) { return Hasher().add(std::as_bytes(std::span(bytes))).finish(); }

std::shared_ptr<MeshAsset> build(TriMesh mesh) {
  static_assert(kMaxTriangles <= TriangleRecord::kMostTriangles);
  auto asset = std::make_shared<MeshAsset>();
  asset->surface = buildSurface(mesh.vertices, mesh.triangles);
  asset->mesh = std::make_shared<const TriMesh>(std::move(mesh));
  return asset;
}

std::shared_ptr<FieldAsset> build(SampledField field) {
  auto asset = std::make_shared<FieldAsset>();
  asset->field = std::make_shared<const SampledField>(std::move(field));
  return asset;
}

std::shared_ptr<VertexValuesAsset> build(std::vector<float> values) {
  auto asset = std::make_shared<VertexValuesAsset>();
  asset->values = std::move(values);
  return asset;
}

std::shared_ptr<MovedVerticesAsset> build(MovedVertices moved) {
  auto asset = std::make_shared<MovedVerticesAsset>();
  asset->moved = std::move(moved);
  return asset;
}

}  // namespace

std::shared_ptr<const MeshAsset> AssetStore::intern(TriMesh mesh) {
  const ContentHash hash = hashOf(mesh);
  if (auto known = as<MeshAsset>(find(hash))) return known;
  std::string encoded = encodeMesh(mesh);
  return keep(build(std::move(mesh)), std::move(encoded), hash);
}

std::shared_ptr<const FieldAsset> AssetStore::intern(SampledField field) {
  const ContentHash hash = hashOf(field);
  if (auto known = as<FieldAsset>(find(hash))) return known;
  std::string encoded = encodeField(field);
  return keep(build(std::move(field)), std::move(encoded), hash);
}

std::shared_ptr<const VertexValuesAsset> AssetStore::intern(std::vector<float> vertexValues) {
  const ContentHash hash = hashOf(vertexValues);
  if (auto known = as<VertexValuesAsset>(find(hash))) return known;
  std::string encoded = encodeVertexValues(vertexValues);
  return keep(build(std::move(vertexValues)), std::move(encoded), hash);
}

std::shared_ptr<const MovedVerticesAsset> AssetStore::intern(MovedVertices moved) {
  const ContentHash hash = hashOf(moved);
  if (auto known = as<MovedVerticesAsset>(find(hash))) return known;
  std::string encoded = encodeMovedVertices(moved);
  return keep(build(std::move(moved)), std::move(encoded), hash);
}

Result<std::shared_ptr<const Asset>> AssetStore::internEncoded(const AssetName& name, std::string bytes) {
  if (auto known = find(name.hash); known && known->name.kind == name.kind) return known;
  const ContentHash actual = hashOfBytes(bytes);
  if (actual != name.hash) {
    return refused("hash", "the bytes hash to " + actual.hex() + ", declared was " + name.hash.hex());
  }
  return keepDecoded(name, std::move(bytes));
}

Result<std::shared_ptr<const Asset>> AssetStore::internEncoded(AssetKind kind, std::string bytes) {
  const AssetName name{kind, hashOfBytes(bytes)};
  if (auto known = find(name.hash); known && known->name.kind == kind) return known;
  return keepDecoded(name, std::move(bytes));
}

Result<std::shared_ptr<const Asset>> AssetStore::keepDecoded(const AssetName& name, std::string bytes) {
  const auto keepContent = [&](auto content) -> Result<std::shared_ptr<const Asset>> {
    if (!content) return refused("data", content.error().text());
    return keep(build(*std::move(content)), std::move(bytes), name.hash);
  };
  switch (name.kind) {
    case AssetKind::kMesh:
      return keepContent(decodeMesh(bytes));
    case AssetKind::kScalarField:
      return keepContent(decodeField(bytes));
    case AssetKind::kVertexValues:
      return keepContent(decodeVertexValues(bytes));
    case AssetKind::kMovedVertices:
      return keepContent(decodeMovedVertices(bytes));
  }
  return refused("kind", "is none that this server knows");
}

template <class Kind>
std::shared_ptr<const Kind> AssetStore::keep(std::shared_ptr<Kind> asset, std::string encoded,
                                             const ContentHash& hash) {
  asset->name = {Kind::kKind, hash};
  asset->encoded = std::make_shared<const std::string>(std::move(encoded));

  const std::lock_guard lock(mutex_);
  std::erase_if(assets_, [](const auto& entry) { return entry.second.expired(); });
  assets_[hash] = asset;
  return asset;
}

std::shared_ptr<const Asset> AssetStore::find(const ContentHash& hash) const {
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

#include "haptic_server/scene/asset_store.h"

#include <algorithm>
#include <span>

#include "common/interruption/interruption.h"
#include "common/mesh/mesh_asset.h"
#include "common/mesh/vertex_values.h"
#include "common/surface/field_asset.h"
#include "common/surface/point_field_asset.h"

namespace haptics {
namespace {

ContentHash hashOfBytes(const std::string& bytes) {
  constexpr std::size_t kPiece_bytes = 1U << 20;
  Hasher hasher;
  for (auto left = std::as_bytes(std::span(bytes)); !left.empty();) {
    interruptionPoint();
    const auto piece = left.first(std::min(kPiece_bytes, left.size()));
    hasher.add(piece);
    left = left.subspan(piece.size());
  }
  return hasher.finish();
}

std::shared_ptr<MeshAsset> build(std::shared_ptr<const TriMesh> mesh) {
  static_assert(kMaxTriangles <= TriangleRecord::kMaxRecords);
  auto asset = std::make_shared<MeshAsset>();
  asset->surface = buildCollisionMesh(mesh->vertices, mesh->triangles);
  asset->mesh = std::move(mesh);
  return asset;
}

template <class Kind, class Content>
std::shared_ptr<Kind> holding(std::shared_ptr<const Content> content, std::shared_ptr<const Content> Kind::*place) {
  auto asset = std::make_shared<Kind>();
  (*asset).*place = std::move(content);
  return asset;
}

auto build(std::shared_ptr<const SampledField> field) { return holding(std::move(field), &FieldAsset::field); }
auto build(std::shared_ptr<const std::vector<float>> values) {
  return holding(std::move(values), &VertexValuesAsset::values);
}
auto build(std::shared_ptr<const MovedVertices> moved) { return holding(std::move(moved), &MovedVerticesAsset::moved); }
auto build(std::shared_ptr<const PointField> field) { return holding(std::move(field), &PointFieldAsset::field); }

}  // namespace

template <class Kind>
std::shared_ptr<const Kind> AssetStore::keep(std::shared_ptr<Kind> asset, const ContentHash& hash) {
  asset->name = {Kind::kKind, hash};

  const std::lock_guard lock(mutex_);
  if (const auto at = assets_.find(hash); at != assets_.end()) {
    if (auto known = as<Kind>(at->second.lock())) return known;  // another thread was faster
  }
  std::erase_if(assets_, [](const auto& entry) { return entry.second.expired(); });
  assets_[hash] = asset;
  return asset;
}

std::shared_ptr<const MeshAsset> AssetStore::intern(TriMesh mesh) { return internContent<MeshAsset>(std::move(mesh)); }

std::shared_ptr<const MeshAsset> AssetStore::intern(TriMesh mesh, std::shared_ptr<const CollisionMesh> surface) {
  auto asset = std::make_shared<MeshAsset>();
  asset->mesh = std::make_shared<const TriMesh>(std::move(mesh));
  asset->surface = std::move(surface);
  const ContentHash hash = hashOf(*asset->mesh);
  return keep(std::move(asset), hash);
}

std::shared_ptr<const FieldAsset> AssetStore::intern(SampledField field) {
  return internContent<FieldAsset>(std::move(field));
}

std::shared_ptr<const VertexValuesAsset> AssetStore::intern(std::vector<float> vertexValues) {
  for (float& value : vertexValues) value += 0.0F;  // -0 + 0 is +0
  return internContent<VertexValuesAsset>(std::move(vertexValues));
}

std::shared_ptr<const MovedVerticesAsset> AssetStore::intern(MovedVertices moved) {
  return internContent<MovedVerticesAsset>(std::move(moved));
}

std::shared_ptr<const PointFieldAsset> AssetStore::intern(PointField field) {
  return internContent<PointFieldAsset>(std::move(field));
}

template <class Kind, class Content>
std::shared_ptr<const Kind> AssetStore::internContent(Content content) {
  const ContentHash hash = canonicalBytes(content).hash();
  if (auto known = as<Kind>(find(hash))) return known;
  return keep(build(std::make_shared<const Content>(std::move(content))), hash);
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
  auto content = decodeAsset(name.kind, bytes);
  if (!content) return refused("data", content.error().text());
  bytes = {};  // before more is made of it
  return std::visit(
      [&](auto decoded) -> std::shared_ptr<const Asset> { return keep(build(std::move(decoded)), name.hash); },
      *std::move(content));
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

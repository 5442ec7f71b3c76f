#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/assets/asset_content.h"
#include "common/error/error.h"
#include "common/hash/content_hash.h"
#include "common/mesh/moved_vertices.h"
#include "common/mesh/tri_mesh.h"
#include "common/scene/asset_source.h"
#include "common/surface/point_field.h"
#include "common/surface/sampled_field.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// An asset, named by the hash of its content. Immutable, shared between threads.
struct Asset {
  AssetName name;  ///< Its hash is that of bytes().

  virtual ~Asset() = default;
  /// May be held on its own: what the server makes of it goes with the asset.
  [[nodiscard]] virtual AssetContent content() const = 0;
  /// Canonical bytes, a view of this asset.
  [[nodiscard]] CanonicalBytes bytes() const { return canonicalBytes(content()); }
};

/// A mesh in the forms that the server needs besides.
struct MeshAsset final : Asset {
  static constexpr AssetKind kKind = AssetKind::kMesh;
  std::shared_ptr<const TriMesh> mesh;
  std::shared_ptr<const CollisionMesh> surface;
  [[nodiscard]] AssetContent content() const override { return mesh; }
};

struct FieldAsset final : Asset {
  static constexpr AssetKind kKind = AssetKind::kScalarField;
  std::shared_ptr<const SampledField> field;
  [[nodiscard]] AssetContent content() const override { return field; }
};

struct VertexValuesAsset final : Asset {
  static constexpr AssetKind kKind = AssetKind::kVertexValues;
  std::shared_ptr<const std::vector<float>> values;
  [[nodiscard]] AssetContent content() const override { return values; }
};

struct MovedVerticesAsset final : Asset {
  static constexpr AssetKind kKind = AssetKind::kMovedVertices;
  std::shared_ptr<const MovedVertices> moved;
  [[nodiscard]] AssetContent content() const override { return moved; }
};

struct PointFieldAsset final : Asset {
  static constexpr AssetKind kKind = AssetKind::kPointField;
  std::shared_ptr<const PointField> field;
  [[nodiscard]] AssetContent content() const override { return field; }
};

/// Null when the asset is of another kind.
template <class Kind>
[[nodiscard]] std::shared_ptr<const Kind> as(std::shared_ptr<const Asset> asset) {
  if (!asset || asset->name.kind != Kind::kKind) return nullptr;
  return std::static_pointer_cast<const Kind>(std::move(asset));
}

/// The assets in use, each once, found by content. It owns none of them: an asset lives as long as the scene's current
/// version, an upload or a client's transfer holds it.
class AssetStore {
 public:
  /// The asset with this content; what is built beside it only when no one holds it yet. Any thread: a mesh takes
  /// O(n log n) time in the triangles, in which the thread may be interrupted.
  [[nodiscard]] std::shared_ptr<const MeshAsset> intern(TriMesh mesh);
  /// @param surface  buildCollisionMesh() of the mesh.
  [[nodiscard]] std::shared_ptr<const MeshAsset> intern(TriMesh mesh, std::shared_ptr<const CollisionMesh> surface);
  [[nodiscard]] std::shared_ptr<const FieldAsset> intern(SampledField field);
  [[nodiscard]] std::shared_ptr<const VertexValuesAsset> intern(std::vector<float> vertexValues);
  [[nodiscard]] std::shared_ptr<const MovedVerticesAsset> intern(MovedVertices moved);
  [[nodiscard]] std::shared_ptr<const PointFieldAsset> intern(PointField field);
  /// The same for canonical bytes from elsewhere. Refused: bytes that do not have this hash, or are not of this kind.
  [[nodiscard]] Result<std::shared_ptr<const Asset>> internEncoded(const AssetName& name, std::string bytes);
  /// Bytes of which no one has said the hash.
  [[nodiscard]] Result<std::shared_ptr<const Asset>> internEncoded(AssetKind kind, std::string bytes);

  /// Any thread. Null when no one holds such an asset.
  [[nodiscard]] std::shared_ptr<const Asset> find(const ContentHash& hash) const;
  [[nodiscard]] std::size_t size() const;  ///< Any thread. Assets alive.

 private:
  mutable std::mutex mutex_;
  std::unordered_map<ContentHash, std::weak_ptr<const Asset>> assets_;

  [[nodiscard]] Result<std::shared_ptr<const Asset>> keepDecoded(const AssetName& name, std::string bytes);
  template <class Kind, class Content>
  std::shared_ptr<const Kind> internContent(Content content);
  template <class Kind>
  std::shared_ptr<const Kind> keep(std::shared_ptr<Kind> asset, const ContentHash& hash);
};

}  // namespace haptics

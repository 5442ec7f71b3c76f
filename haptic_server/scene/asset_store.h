#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

#include "common/error/error.h"
#include "common/hash/content_hash.h"
#include "common/mesh/tri_mesh.h"
#include "haptic_server/geometry/surface.h"

namespace haptics {

/// A mesh in the three forms that the server needs. Immutable, shared between threads.
struct MeshAsset {
  ContentHash hash;  ///< Of `encoded`.
  std::shared_ptr<const TriMesh> mesh;
  std::shared_ptr<const Surface> surface;
  std::shared_ptr<const std::string> encoded;  ///< As clients get it (encodeMesh).
};

/// The meshes in use, each once, found by content. It owns none of them: a mesh lives as long as the scene's current
/// version, an upload or a client's transfer holds it.
class AssetStore {
 public:
  /// The asset with this content; its surface is built only when no one holds it yet. Builder thread: takes
  /// O(n log n) time in the triangles.
  [[nodiscard]] std::shared_ptr<const MeshAsset> intern(TriMesh mesh);
  /// The same for canonical bytes from elsewhere. Refused: bytes that do not have this hash, or are not a mesh.
  [[nodiscard]] Result<std::shared_ptr<const MeshAsset>> internEncoded(const ContentHash& hash, std::string bytes);

  /// Any thread. Null when no one holds such an asset.
  [[nodiscard]] std::shared_ptr<const MeshAsset> find(const ContentHash& hash) const;
  [[nodiscard]] std::size_t size() const;  ///< Any thread. Assets alive.

 private:
  mutable std::mutex mutex_;
  std::unordered_map<ContentHash, std::weak_ptr<const MeshAsset>> assets_;

  std::shared_ptr<const MeshAsset> build(TriMesh mesh, std::string encoded, const ContentHash& hash);
};

}  // namespace haptics

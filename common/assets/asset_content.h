#pragma once

#include <memory>
#include <string_view>
#include <variant>
#include <vector>

#include "common/error/error.h"
#include "common/mesh/canonical_bytes.h"
#include "common/mesh/moved_vertices.h"
#include "common/mesh/tri_mesh.h"
#include "common/scene/asset_source.h"
#include "common/surface/point_field.h"
#include "common/surface/sampled_field.h"

namespace haptics {

/// The decoded content of an asset. Immutable and never null: threads share it, and so do a server and a client
/// in one process.
using AssetContent = std::variant<std::shared_ptr<const TriMesh>, std::shared_ptr<const SampledField>,
                                  std::shared_ptr<const std::vector<float>>, std::shared_ptr<const MovedVertices>,
                                  std::shared_ptr<const PointField>>;

[[nodiscard]] AssetKind kindOf(const AssetContent& content) noexcept;

/// The bytes that are hashed and sent, where the content has them.
[[nodiscard]] CanonicalBytes canonicalBytes(const AssetContent& content);

/// Refused: what the kind's decoder refuses (decodeMesh, decodeField, decodeVertexValues, decodeMovedVertices,
/// decodePointField).
[[nodiscard]] Result<AssetContent> decodeAsset(AssetKind kind, std::string_view bytes);

}  // namespace haptics

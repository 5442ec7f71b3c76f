#include "common/assets/asset_content.h"

#include <array>
#include <utility>

#include "common/mesh/mesh_asset.h"
#include "common/mesh/vertex_values.h"
#include "common/surface/field_asset.h"
#include "common/surface/point_field_asset.h"

namespace haptics {

AssetKind kindOf(const AssetContent& content) noexcept {
  constexpr std::array<AssetKind, std::variant_size_v<AssetContent>> kKinds{
      AssetKind::kMesh, AssetKind::kScalarField, AssetKind::kVertexValues, AssetKind::kMovedVertices,
      AssetKind::kPointField};
  return kKinds[content.index()];
}

CanonicalBytes canonicalBytes(const AssetContent& content) {
  return std::visit([](const auto& held) { return canonicalBytes(*held); }, content);
}

Result<AssetContent> decodeAsset(AssetKind kind, std::string_view bytes) {
  const auto shared = [](auto decoded) -> Result<AssetContent> {
    if (!decoded) return tl::unexpected<Error>(std::move(decoded).error());
    return std::make_shared<const typename decltype(decoded)::value_type>(*std::move(decoded));
  };
  switch (kind) {
    case AssetKind::kMesh:
      return shared(decodeMesh(bytes));
    case AssetKind::kScalarField:
      return shared(decodeField(bytes));
    case AssetKind::kVertexValues:
      return shared(decodeVertexValues(bytes));
    case AssetKind::kMovedVertices:
      return shared(decodeMovedVertices(bytes));
    case AssetKind::kPointField:
      return shared(decodePointField(bytes));
  }
  return refused("kind", "is none that this program knows");
}

}  // namespace haptics

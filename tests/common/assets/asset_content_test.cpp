#include "common/assets/asset_content.h"

#include <gtest/gtest.h>

#include "common/mesh/generators.h"
#include "common/mesh/mesh_asset.h"
#include "common/mesh/vertex_values.h"
#include "common/surface/field_asset.h"
#include "common/surface/point_field_asset.h"

namespace haptics::asset_content_test {
namespace {

template <class Value>
std::shared_ptr<const Value> shared(Value value) {
  return std::make_shared<const Value>(std::move(value));
}

/// One of each kind, with its canonical bytes by the kind's own encoder.
std::vector<std::pair<AssetContent, std::string>> oneOfEach() {
  const TriMesh mesh = makeBox(Vec3(0.1), 2).value();
  const SampledField field = SampledField::make(2, 3, {0, 1, 2, 3, 4, 5}).value();
  const std::vector<float> values{0, 0.5F, 1};
  const MovedVertices moved{{2, 5}, {{1, 2, 3}, {0, 0, -1}}};
  const PointField points = PointField::make(0.5F, {{{0, 0, 0}, 1}, {{0.25F, 0, 0}, -1}}).value();
  return {{shared(mesh), encodeMesh(mesh)},
          {shared(field), encodeField(field)},
          {shared(values), encodeVertexValues(values)},
          {shared(moved), encodeMovedVertices(moved)},
          {shared(points), encodePointField(points)}};
}

TEST(AssetContent, ComesBackFromItsBytesWhateverItsKind) {
  for (const auto& [content, bytes] : oneOfEach()) {
    const auto decoded = decodeAsset(kindOf(content), bytes);
    ASSERT_TRUE(decoded) << decoded.error().text();
    EXPECT_EQ(kindOf(*decoded), kindOf(content));
    EXPECT_EQ(canonicalBytes(*decoded).copy(), bytes);
  }
}

TEST(AssetContent, IsRefusedAsAnotherKind) {
  for (const auto& [content, bytes] : oneOfEach()) {
    for (const auto& [other, itsBytes] : oneOfEach()) {
      EXPECT_TRUE(kindOf(other) == kindOf(content) || !decodeAsset(kindOf(content), itsBytes));
    }
  }
}

TEST(CanonicalBytes, AreThoseOfTheEncoderInWhateverPieces) {
  for (const auto& [content, bytes] : oneOfEach()) {
    const CanonicalBytes view = canonicalBytes(content);
    EXPECT_EQ(view.size(), bytes.size());
    EXPECT_EQ(view.hash(), Hasher().add(std::as_bytes(std::span(bytes))).finish());
    for (const std::size_t piece : {1, 7, 16, 24, 1000}) {
      std::string gathered;
      while (gathered.size() < bytes.size()) gathered += view.copy(gathered.size(), piece);
      EXPECT_EQ(gathered, bytes) << piece;
    }
    EXPECT_EQ(view.copy(bytes.size() - 1), bytes.substr(bytes.size() - 1));
    EXPECT_EQ(view.copy(bytes.size()), "");
  }
}

}  // namespace
}  // namespace haptics::asset_content_test

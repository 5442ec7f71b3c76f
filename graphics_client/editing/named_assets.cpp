#include "graphics_client/editing/named_assets.h"

#include <string>
#include <utility>
#include <vector>

namespace haptics {

namespace pb = google::protobuf;

void forEachMessage(pb::Message& message, const std::function<void(pb::Message&)>& visit) {
  visit(message);
  const pb::Reflection& reflection = *message.GetReflection();
  std::vector<const pb::FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const auto* field : fields) {
    if (field->cpp_type() != pb::FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (!field->is_repeated()) {
      forEachMessage(*reflection.MutableMessage(&message, field), visit);
      continue;
    }
    for (int i = 0; i < reflection.FieldSize(message, field); ++i) {
      forEachMessage(*reflection.MutableRepeatedMessage(&message, field, i), visit);
    }
  }
}

std::set<AssetName> assetsNamedBy(v1::Transaction transaction) {
  std::set<AssetName> names;
  const auto add = [&names](AssetKind kind, const auto* message) {
    if (message == nullptr) return;
    if (const auto hash = ContentHash::fromBytes(message->asset())) names.insert({kind, *hash});
  };
  forEachMessage(transaction, [&add](pb::Message& message) {
    add(AssetKind::kMesh, dynamic_cast<v1::MeshSource*>(&message));
    add(AssetKind::kScalarField, dynamic_cast<v1::MappedField*>(&message));
    add(AssetKind::kPointField, dynamic_cast<v1::GrownField*>(&message));
    add(AssetKind::kVertexValues, dynamic_cast<v1::PerVertex*>(&message));
    add(AssetKind::kMovedVertices, dynamic_cast<v1::Residue*>(&message));
  });
  return names;
}

std::set<AssetName> assetsNamedBy(const SceneVersion& scene) {
  std::set<AssetName> names;
  for (const auto& object : scene.objects()) {
    for (const AssetName& name : object->assets()) names.insert(name);
  }
  return names;
}

std::optional<AssetContent> assetIn(const MirrorView& view, const AssetName& name) {
  const auto find = [&name](const auto& assets) -> std::optional<AssetContent> {
    const auto at = assets.find(name.hash);
    if (at == assets.end()) return std::nullopt;
    return at->second;
  };
  switch (name.kind) {
    case AssetKind::kMesh:
      return find(view.meshes);
    case AssetKind::kScalarField:
      return find(view.fields);
    case AssetKind::kVertexValues:
      return find(view.vertexValues);
    case AssetKind::kMovedVertices:
      return find(view.movedVertices);
    case AssetKind::kPointField:
      return find(view.pointFields);
  }
  return std::nullopt;
}

}  // namespace haptics

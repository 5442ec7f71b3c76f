#include "graphics_client/editing/named_assets.h"

#include <string>
#include <utility>
#include <vector>

namespace haptics {

namespace pb = google::protobuf;

namespace {

/// Messages that name assets, by what they name.
std::optional<AssetKind> kindNamedBy(const pb::Message& message) {
  const pb::Descriptor* const is = message.GetDescriptor();
  if (is == v1::MeshSource::descriptor()) return AssetKind::kMesh;
  if (is == v1::MappedField::descriptor()) return AssetKind::kScalarField;
  if (is == v1::GrownField::descriptor()) return AssetKind::kPointField;
  if (is == v1::PerVertex::descriptor()) return AssetKind::kVertexValues;
  if (is == v1::Residue::descriptor()) return AssetKind::kMovedVertices;
  return std::nullopt;
}

using Visit = std::function<Result<void>(AssetReference&)>;

Result<void> visitAll(pb::Message& message, const std::string& path, const Visit& visit) {
  if (const auto kind = kindNamedBy(message)) {
    AssetReference reference(*kind, message, path);
    if (auto done = visit(reference); !done) return done;
  }
  const pb::Reflection& reflection = *message.GetReflection();
  std::vector<const pb::FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const auto* field : fields) {
    if (field->cpp_type() != pb::FieldDescriptor::CPPTYPE_MESSAGE) continue;
    const std::string name = (path.empty() ? "" : path + ".") + field->name();
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      auto done = field->is_repeated() ? visitAll(*reflection.MutableRepeatedMessage(&message, field, i),
                                                  name + "[" + std::to_string(i) + "]", visit)
                                       : visitAll(*reflection.MutableMessage(&message, field), name, visit);
      if (!done) return done;
    }
  }
  return {};
}

}  // namespace

AssetReference::AssetReference(AssetKind kind, pb::Message& message, std::string path)
    : kind_(kind),
      message_(message),
      asset_(*message.GetDescriptor()->FindFieldByName("asset")),
      file_(*message.GetDescriptor()->FindFieldByName(kind == AssetKind::kScalarField ? "image" : "file")),
      path_(std::move(path)) {}

std::optional<AssetName> AssetReference::asset() const {
  const auto hash = ContentHash::fromBytes(message_.GetReflection()->GetString(message_, &asset_));
  if (!hash) return std::nullopt;
  return AssetName{kind_, *hash};
}

std::string AssetReference::file() const { return message_.GetReflection()->GetString(message_, &file_); }

void AssetReference::setAsset(const ContentHash& hash) {
  if (auto* mesh = dynamic_cast<v1::MeshSource*>(&message_)) {
    v1::MeshSource whole;
    if (mesh->has_simplify()) *whole.mutable_simplify() = mesh->simplify();
    mesh->Swap(&whole);
  }
  message_.GetReflection()->SetString(&message_, &asset_, hash.asBytes());
}

void AssetReference::setFile(const std::string& name) { message_.GetReflection()->SetString(&message_, &file_, name); }

Result<void> forEachReference(pb::Message& message, const Visit& visit) { return visitAll(message, "", visit); }

std::set<AssetName> assetsNamedBy(v1::Transaction transaction) {
  std::set<AssetName> names;
  static_cast<void>(forEachReference(transaction, [&names](const AssetReference& reference) -> Result<void> {
    if (const auto name = reference.asset()) names.insert(*name);
    return {};
  }));
  return names;
}

std::set<AssetName> assetsNamedBy(const SceneVersion& scene) {
  std::set<AssetName> names;
  for (const auto& object : scene.objects()) {
    for (const AssetName& name : object->assets()) names.insert(name);
  }
  return names;
}

}  // namespace haptics

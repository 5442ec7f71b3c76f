#pragma once

#include <google/protobuf/message.h>

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "common/assets/asset_content.h"
#include "common/error/error.h"
#include "common/scene/asset_source.h"
#include "graphics_client/mirror/mirror_view.h"
#include "haptics/v1/scene.pb.h"

namespace haptics {

using NamedAssets = std::map<AssetName, AssetContent>;

/// A message that says where an asset comes from: a MeshSource, MappedField, GrownField, PerVertex or Residue.
class AssetReference {
 public:
  /// @param path  Of the message: "operations[0].add.mesh".
  AssetReference(AssetKind kind, google::protobuf::Message& message, std::string path);

  [[nodiscard]] AssetKind kind() const noexcept { return kind_; }
  [[nodiscard]] std::optional<AssetName> asset() const;  ///< Nothing: it is named otherwise, or by no hash.
  [[nodiscard]] std::string file() const;                ///< Empty: it is named otherwise.
  [[nodiscard]] std::string fileField() const { return path_ + "." + file_.name(); }
  /// With the options of a file; null: it is no mesh.
  [[nodiscard]] const v1::MeshSource* mesh() const { return dynamic_cast<const v1::MeshSource*>(&message_); }
  /// In place of what it named; options that are for files go with them.
  void setAsset(const ContentHash& hash);
  void setFile(const std::string& name);
  void setGenerator(const v1::MeshSource& source) { message_.CopyFrom(source); }  ///< Of a mesh.

 private:
  AssetKind kind_;
  google::protobuf::Message& message_;
  const google::protobuf::FieldDescriptor &asset_, &file_;
  std::string path_;
};

/// Visits each in the message, in the order of fields, until one is refused.
[[nodiscard]] Result<void> forEachReference(google::protobuf::Message& message,
                                            const std::function<Result<void>(AssetReference&)>& visit);

/// Assets that the transaction names by their hash. What has no hash's size is left out: the server refuses it.
[[nodiscard]] std::set<AssetName> assetsNamedBy(v1::Transaction transaction);
[[nodiscard]] std::set<AssetName> assetsNamedBy(const SceneVersion& scene);

}  // namespace haptics

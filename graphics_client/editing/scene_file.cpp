#include "graphics_client/editing/scene_file.h"

#include <cstddef>
#include <fstream>
#include <span>
#include <string>
#include <system_error>
#include <utility>

#include "common/mesh/file_bytes.h"
#include "common/wire/convert.h"
#include "graphics_client/editing/named_assets.h"
#include "graphics_client/editing/scene_text.h"
#include "graphics_client/mirror/client_limits.h"

namespace haptics {
namespace {

namespace fs = std::filesystem;

const char* extensionOf(AssetKind kind) {
  switch (kind) {
    case AssetKind::kMesh:
      return ".mesh";
    case AssetKind::kScalarField:
      return ".field";
    case AssetKind::kVertexValues:
      return ".values";
    case AssetKind::kMovedVertices:
      return ".moved";
    case AssetKind::kPointField:
      return ".points";
  }
  return "";
}

fs::path fileOf(const AssetName& asset, const fs::path& scene) {
  return scene.parent_path() / (asset.hash.hex() + extensionOf(asset.kind));
}

/// Whole or not at all.
Result<void> write(const fs::path& file, const std::string& bytes) {
  const fs::path partial = file.string() + ".part";
  std::ofstream out(partial, std::ios::binary);
  out << bytes;
  out.close();
  std::error_code why;
  if (!out) {
    fs::remove(partial, why);
    return refused(file.string(), "cannot be written; name a file in an existing folder that you may write to");
  }
  fs::rename(partial, file, why);
  if (why) return refused(file.string(), why.message());
  return {};
}

Result<AssetContent> read(const AssetName& asset, const fs::path& file) {
  std::error_code ignored;
  if (const auto size = fs::file_size(file, ignored); !ignored && size > kMaxHeldAssets_bytes) {
    return refused(file.string(), "has " + std::to_string(size) + " bytes; a scene's assets have at most " +
                                      std::to_string(kMaxHeldAssets_bytes));
  }
  const auto bytes = readFile(file);
  if (!bytes) return refused(file.string(), bytes.error().reason);
  if (Hasher().add(std::as_bytes(std::span(*bytes))).finish() != asset.hash) {
    return refused(file.string(), "is damaged: its bytes do not have the hash of its name");
  }
  auto content = decodeAsset(asset.kind, *bytes);
  if (!content) return refused(file.string() + ": " + content.error().field, content.error().reason);
  return content;
}

/// The assets that the transaction names and the present scene does not.
/// @param mayLack  Those that do not lie beside the file are left out, not refused.
Result<std::vector<AssetContent>> readAssets(const fs::path& file, const v1::Transaction& transaction,
                                             const SceneVersion& present, bool mayLack) {
  std::vector<AssetContent> assets;
  const auto held = assetsNamedBy(present);
  for (const AssetName& name : assetsNamedBy(transaction)) {
    std::error_code ignored;
    const fs::path beside = fileOf(name, file);
    if (held.contains(name) || (mayLack && !fs::exists(beside, ignored))) continue;
    auto content = read(name, beside);
    if (!content) return tl::unexpected(std::move(content).error());
    assets.push_back(*std::move(content));
  }
  return assets;
}

}  // namespace

Result<void> saveScene(const MirrorView& view, const fs::path& file) {
  const SceneVersion& scene = *view.scene;
  const std::string text = sceneText(view, "");
  if (text.size() > kMaxSceneTextBytes) {
    return refused(file.string(), "would have " + std::to_string(text.size()) + " bytes; a scene file has at most " +
                                      std::to_string(kMaxSceneTextBytes) + ": give lattices and creases less detail");
  }
  for (const auto& object : scene.objects()) {
    if (view.isComplete(*object)) continue;
    return refused(file.string(), "cannot be written yet: assets of object \"" + object->name + "\" are on their way");
  }
  std::vector<AssetContent> assets;
  for (const AssetName& name : assetsNamedBy(scene)) assets.push_back(*assetIn(view, name));
  if (auto written = saveBeside(file, assets); !written) return written;
  return write(file, text);
}

Result<void> saveBeside(const fs::path& file, const std::vector<AssetContent>& assets) {
  for (const AssetContent& content : assets) {
    const CanonicalBytes bytes = canonicalBytes(content);
    if (auto written = write(fileOf({kindOf(content), bytes.hash()}, file), bytes.copy()); !written) return written;
  }
  return {};
}

Result<Edit> openScene(const fs::path& file, const SceneVersion& present) {
  auto transaction = readSceneFile(file.string());
  if (!transaction) return tl::unexpected(std::move(transaction).error());
  auto uploads = readAssets(file, *transaction, present, false);
  if (!uploads) return tl::unexpected(std::move(uploads).error());
  Edit edit{{}, "Open " + file.filename().string(), *std::move(uploads)};
  for (const auto& object : present.objects()) {
    edit.transaction.add_operations()->mutable_remove()->mutable_object()->set_id(object->id);
  }
  edit.transaction.MergeFrom(*transaction);
  return edit;
}

Result<std::vector<AssetContent>> assetsBeside(const fs::path& file, const v1::Transaction& transaction,
                                               const SceneVersion& present) {
  return readAssets(file, transaction, present, true);
}

}  // namespace haptics

#include "graphics_client/editing/scene_file.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "common/mesh/file_bytes.h"
#include "common/wire/convert.h"
#include "graphics_client/editing/generated_mesh.h"
#include "graphics_client/editing/named_assets.h"
#include "graphics_client/editing/scene_text.h"

namespace haptics {
namespace {

namespace fs = std::filesystem;

/// The files beside a scene file.
class AssetFiles {
 public:
  AssetFiles(const fs::path& folder, const MirrorView& view) : folder_(folder), view_(view) {}

  /// The name of the asset's file, which is written unless it is there.
  Result<std::string> nameOf(const AssetName& asset, const std::string& object) {
    if (const auto known = names_.find(asset); known != names_.end()) return known->second;
    const auto content = view_.contentOf(asset);
    if (!content) {
      return refused("object \"" + object + "\"", "cannot be written yet: its assets are on their way");
    }
    const std::string bytes = canonicalBytes(*content).copy();
    const std::string ending(fileEndingOf(asset.kind));
    for (int number = 1;; ++number) {
      const std::string name = object + (number > 1 ? "-" + std::to_string(number) : "") + ending;
      const fs::path file = folder_ / name;
      std::error_code error;
      if (!fs::exists(file, error)) {
        if (auto written = writeFile(file, bytes); !written) return tl::unexpected(written.error());
      } else if (fs::file_size(file, error) != bytes.size() || readAssetFile(file).value_or("") != bytes) {
        continue;
      }
      return names_.emplace(asset, name).first->second;
    }
  }

 private:
  const fs::path folder_;
  const MirrorView& view_;
  std::map<AssetName, std::string> names_;
};

/// Whether a name leads nowhere but to the folder and what is below.
bool staysBelow(const fs::path& name) {
  return !name.empty() && name.is_relative() && std::find(name.begin(), name.end(), "..") == name.end();
}

}  // namespace

Result<std::string> sceneFor(const std::optional<fs::path>& folder, const MirrorView& view, const std::string& name) {
  v1::Transaction transaction = additionsOf(view, name);
  AssetFiles files(folder.value_or(fs::path()), view);
  for (v1::Operation& operation : *transaction.mutable_operations()) {
    v1::AddObject& add = *operation.mutable_add();
    auto done = forEachReference(add, [&](AssetReference& reference) -> Result<void> {
      const auto asset = reference.asset();
      if (!asset) return {};
      const auto mesh = view.meshes.find(asset->hash);
      if (reference.kind() == AssetKind::kMesh && mesh != view.meshes.end()) {
        if (const auto generator = generatorOf(*mesh->second)) {
          reference.setGenerator(*generator);
          return {};
        }
      }
      if (!folder) return {};
      return files.nameOf(*asset, add.name()).map([&](const std::string& file) { reference.setFile(file); });
    });
    if (!done) return tl::unexpected(std::move(done).error());
  }
  std::string text = textOf(transaction);
  if (text.size() <= kMaxSceneTextBytes) return text;
  return refused("", "would have " + std::to_string(text.size()) + " bytes; a scene file has at most " +
                         std::to_string(kMaxSceneTextBytes) + ": give lattices and creases less detail");
}

Result<void> saveScene(const MirrorView& view, const fs::path& file) {
  if (view.epoch == 0 && !view.isReplay) return refused(file.string(), "no scene has come from a server yet");
  auto text = sceneFor(file.parent_path(), view);
  if (!text) return refused(file.string(), text.error().text());
  return writeFile(file, *text);
}

Result<void> takeFilesBeside(const fs::path& scene, v1::Transaction& transaction,
                             const std::function<Result<void>(const std::string& name, LocalFile file)>& take) {
  return forEachReference(transaction, [&](AssetReference& reference) -> Result<void> {
    const auto named = reference.asset();  // as scenes were saved before: by a file named after the hash
    const std::string name = named ? named->hash.hex() + std::string(fileEndingOf(named->kind)) : reference.file();
    const fs::path beside = scene.parent_path() / name;
    std::error_code ignored;
    if (!staysBelow(name) || !fs::exists(beside, ignored)) return {};
    auto file = readNamedFile(reference, beside);
    if (!file) return tl::unexpected(std::move(file).error().within(reference.fileField() + ": "));
    const ContentHash hash = file->asset.hash;
    if (named && named->hash != hash) return refused(beside.string(), "is damaged: it has not the hash of its name");
    if (auto taken = take(name, *std::move(file)); !taken) return taken;
    reference.setAsset(hash);
    return {};
  });
}

Result<Edit> openScene(const fs::path& file, const SceneVersion& present) {
  auto transaction = readSceneFile(file.string());
  if (!transaction) return tl::unexpected(std::move(transaction).error());
  Edit edit{{}, "Open " + file.filename().string(), {}};
  std::set<AssetName> held = assetsNamedBy(present);
  auto taken = takeFilesBeside(file, *transaction, [&](const std::string&, const LocalFile& beside) -> Result<void> {
    if (!held.insert({beside.asset.kind, beside.asset.hash}).second) return {};
    auto content = decodeAsset(beside.asset.kind, beside.asset.bytes);
    if (!content) return tl::unexpected(std::move(content).error());
    edit.uploads.push_back(*std::move(content));
    return {};
  });
  if (!taken) return tl::unexpected(std::move(taken).error());
  for (const auto& object : present.objects()) {
    edit.transaction.add_operations()->mutable_remove()->mutable_object()->set_id(object->id);
  }
  edit.transaction.MergeFrom(*transaction);
  return edit;
}

int removalsBefore(const Edit& opened) {
  const auto& operations = opened.transaction.operations();
  const auto isRemoval = [](const v1::Operation& operation) { return operation.has_remove(); };
  return static_cast<int>(std::ranges::find_if_not(operations, isRemoval) - operations.begin());
}

Error asInFile(Error error, int removals) {
  constexpr std::string_view kOperation = "operations[";
  for (std::string* text : {&error.field, &error.reason}) {
    for (auto at = text->find(kOperation); at != std::string::npos; at = text->find(kOperation, at)) {
      at += kOperation.size();
      const auto end = text->find(']', at);
      int number = 0;
      const char* const last = text->data() + std::min(end, text->size());
      if (std::from_chars(text->data() + at, last, number).ptr == last && number >= removals)
        text->replace(at, end - at, std::to_string(number - removals));
    }
  }
  return error;
}

}  // namespace haptics

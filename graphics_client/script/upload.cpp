#include "graphics_client/script/upload.h"

#include <atomic>
#include <cstdio>
#include <future>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "common/clock/monotonic.h"
#include "common/importer/importer.h"
#include "common/surface/field_asset.h"
#include "common/text/printable.h"
#include "graphics_client/editing/local_asset.h"
#include "graphics_client/editing/named_assets.h"
#include "graphics_client/editing/scene_file.h"
#include "graphics_client/script/interrupt.h"
#include "graphics_client/script/progress_bar.h"

namespace haptics {
namespace {

v1::MeshSource* meshOf(v1::Operation& operation) {
  if (operation.has_add()) return operation.mutable_add()->mutable_mesh();
  if (operation.has_remesh()) return operation.mutable_remesh()->mutable_mesh();
  return nullptr;
}

constexpr double kMegabyte = 1e6;
/// Of an upload, by a slow server: it says nothing of it until it is built.
constexpr double kBuilt_bytes_per_s = 1e6;

void showUpload(const std::string& name, std::uint64_t sent_bytes, std::uint64_t total_bytes) {
  char total[32];
  std::snprintf(total, sizeof total, "of %.1f MB ", static_cast<double>(total_bytes) / kMegabyte);
  showProgress("uploading " + name, static_cast<double>(sent_bytes) / static_cast<double>(total_bytes), total);
}

Result<LocalAsset> meshIn(const std::filesystem::path& file, const v1::MeshSource& source) {
  auto mesh = readMeshFile(file, importOptionsOf(source));
  if (!mesh) return tl::unexpected(std::move(mesh).error());
  std::fprintf(stderr, "%s: %s\n", file.c_str(), printable(mesh->report.text()).c_str());
  return std::move(mesh->asset);
}

Result<LocalAsset> fieldIn(const std::filesystem::path& file) {
  auto bytes = importImage(file);
  if (!bytes) return tl::unexpected(std::move(bytes).error());
  const auto field = decodeField(*bytes);
  if (!field) return refused(file.string(), field.error().text());
  std::fprintf(stderr, "%s: %u x %u samples\n", file.c_str(), field->width(), field->height());
  return localAsset(AssetKind::kScalarField, *std::move(bytes));
}

/// Returns once the server holds it.
Result<void> uploadOne(Connection& connection, const std::string& name, const std::filesystem::path& file,
                       LocalAsset asset) {
  const Interrupt interrupt;
  const auto finished = std::make_shared<std::promise<v1::AssetUploadReply>>();
  const auto moved = std::make_shared<std::atomic<std::uint64_t>>(0);
  const double building_s = static_cast<double>(asset.bytes.size()) / kBuilt_bytes_per_s;
  connection.link().upload(asset.kind, std::move(asset.bytes),
                           {[shown = printable(name), moved](std::uint64_t sent_bytes, std::uint64_t total_bytes) {
                              *moved = sent_bytes;
                              showUpload(shown, sent_bytes, total_bytes);
                            },
                            [finished](const v1::AssetUploadReply& reply) { finished->set_value(reply); }});
  const auto reply =
      connection.await(finished->get_future(), [&, seen = std::uint64_t{0}, last_ns = monotonicNow_ns()]() mutable {
        if (Interrupt::interrupted()) connection.link().cancelUpload(asset.hash);
        const std::uint64_t now_ns = monotonicNow_ns();
        if (std::exchange(seen, *moved) != *moved) last_ns = now_ns;
        return static_cast<double>(now_ns - last_ns) < 1e9 * building_s;
      });
  endProgress();
  if (Interrupt::interrupted()) return refused(file.string(), "the upload was cancelled; nothing was changed");
  if (!reply) return tl::unexpected(reply.error());
  return outcomeOf(*reply, file);
}

}  // namespace

Result<void> uploadFiles(Connection& connection, const std::map<std::string, std::filesystem::path>& files,
                         v1::Transaction& transaction) {
  std::set<std::string> used;
  const auto upload = [&](const std::string& name, auto read, auto put) -> Result<void> {
    const auto file = files.find(name);
    if (file == files.end()) return {};
    used.insert(name);
    auto asset = read(file->second);
    if (!asset) return tl::unexpected(std::move(asset).error());
    const ContentHash hash = asset->hash;
    if (auto sent = uploadOne(connection, file->first, file->second, *std::move(asset)); !sent) return sent;
    put(hash.asBytes());
    return {};
  };
  for (auto& operation : *transaction.mutable_operations()) {
    v1::MeshSource* mesh = meshOf(operation);
    if (mesh != nullptr && mesh->has_file()) {
      auto sent = upload(
          std::string(mesh->file()), [&](const auto& file) { return meshIn(file, *mesh); },
          [&](const std::string& hash) {
            mesh->Clear();
            mesh->set_asset(hash);
          });
      if (!sent) return sent;
    }
    std::vector<v1::MappedField*> images;
    forEachMessage(operation, [&images](google::protobuf::Message& message) {
      auto* mapped = dynamic_cast<v1::MappedField*>(&message);
      if (mapped != nullptr && mapped->source_case() == v1::MappedField::kImage) images.push_back(mapped);
    });
    for (v1::MappedField* field : images) {
      auto sent =
          upload(std::string(field->image()), fieldIn, [&](const std::string& hash) { field->set_asset(hash); });
      if (!sent) return sent;
    }
  }
  for (const auto& [name, file] : files) {
    if (!used.contains(name)) return refused("--upload " + name, "no mesh or image of the scene names this file");
  }
  return {};
}

Result<void> uploadBeside(Connection& connection, const std::filesystem::path& scene,
                          const v1::Transaction& transaction, const SceneVersion& present) {
  const auto assets = assetsBeside(scene, transaction, present);
  if (!assets) return tl::unexpected(assets.error());
  for (const AssetContent& content : *assets) {
    LocalAsset asset = localAsset(kindOf(content), canonicalBytes(content).copy());
    const std::string name = asset.hash.hex();
    if (auto sent = uploadOne(connection, name, scene, std::move(asset)); !sent) return sent;
  }
  return {};
}

}  // namespace haptics

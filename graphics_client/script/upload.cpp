#include "graphics_client/script/upload.h"

#include <unistd.h>

#include <cstdio>
#include <future>
#include <memory>
#include <set>
#include <utility>

#include "common/mesh/import.h"
#include "common/mesh/mesh_asset.h"

namespace haptics {
namespace {

v1::MeshSource* meshOf(v1::Operation& operation) {
  if (operation.has_add()) return operation.mutable_add()->mutable_mesh();
  if (operation.has_remesh()) return operation.mutable_remesh()->mutable_mesh();
  return nullptr;
}

void showProgress(const std::string& name, std::uint64_t sent_bytes, std::uint64_t total_bytes) {
  if (isatty(STDERR_FILENO) == 0) return;
  std::fprintf(stderr, "\ruploading %s: %3d %%%s", name.c_str(), static_cast<int>(100 * sent_bytes / total_bytes),
               sent_bytes == total_bytes ? "\n" : "");
}

Result<void> uploadOne(Connection& connection, const std::string& name, const std::filesystem::path& file,
                       v1::MeshSource& source) {
  ImportOptions options;
  if (source.has_unit_m()) options.unit_m = source.unit_m();
  if (source.has_largest_extent_m()) options.largestExtent_m = source.largest_extent_m();
  const auto imported = importMesh(file, options);
  if (!imported) return tl::unexpected(imported.error());
  std::fprintf(stderr, "%s: %s\n", file.c_str(), imported->report.text().c_str());

  const auto finished = std::make_shared<std::promise<v1::AssetUploadReply>>();
  connection.link().upload(
      encodeMesh(imported->mesh),
      {[name](std::uint64_t sent_bytes, std::uint64_t total_bytes) { showProgress(name, sent_bytes, total_bytes); },
       [finished](const v1::AssetUploadReply& reply) { finished->set_value(reply); }});
  const auto reply = connection.await(finished->get_future());
  if (!reply) return tl::unexpected(reply.error());
  if (!reply->accepted()) return refused(file.string() + ": " + reply->field(), reply->reason());
  source.Clear();
  source.set_asset(hashOf(imported->mesh).asBytes());
  return {};
}

}  // namespace

Result<void> uploadMeshes(Connection& connection, const std::map<std::string, std::filesystem::path>& files,
                          v1::Transaction& transaction) {
  std::set<std::string> used;
  for (auto& operation : *transaction.mutable_operations()) {
    v1::MeshSource* source = meshOf(operation);
    if (source == nullptr || !source->has_file()) continue;
    const auto file = files.find(source->file());
    if (file == files.end()) continue;
    used.insert(file->first);
    if (auto sent = uploadOne(connection, file->first, file->second, *source); !sent) return sent;
  }
  for (const auto& [name, file] : files) {
    if (!used.contains(name)) return refused("--upload " + name, "no mesh of the scene names this file");
  }
  return {};
}

}  // namespace haptics

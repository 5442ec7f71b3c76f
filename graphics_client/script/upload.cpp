#include "graphics_client/script/upload.h"

#include <unistd.h>

#include <cstddef>
#include <cstdio>
#include <future>
#include <memory>
#include <set>
#include <utility>

#include "common/mesh/import.h"
#include "common/mesh/mesh_asset.h"
#include "graphics_client/script/interrupt.h"

namespace haptics {
namespace {

v1::MeshSource* meshOf(v1::Operation& operation) {
  if (operation.has_add()) return operation.mutable_add()->mutable_mesh();
  if (operation.has_remesh()) return operation.mutable_remesh()->mutable_mesh();
  return nullptr;
}

constexpr double kMegabyte = 1e6;

/// A line on the terminal that is drawn over and over, if there is a terminal.
void showProgress(const std::string& name, std::uint64_t sent_bytes, std::uint64_t total_bytes) {
  constexpr int kBar = 30;  // characters
  if (isatty(STDERR_FILENO) == 0) return;
  const double share = static_cast<double>(sent_bytes) / static_cast<double>(total_bytes);
  const std::string bar(static_cast<std::size_t>(kBar * share), '#');
  std::fprintf(stderr, "\ruploading %s [%-*s] %3d %% of %.1f MB ", name.c_str(), kBar, bar.c_str(),
               static_cast<int>(100 * share), static_cast<double>(total_bytes) / kMegabyte);
}

void endProgress() {
  if (isatty(STDERR_FILENO) != 0) std::fputc('\n', stderr);
}

Result<void> uploadOne(Connection& connection, const std::string& name, const std::filesystem::path& file,
                       v1::MeshSource& source) {
  ImportOptions options;
  if (source.has_unit_m()) options.unit_m = source.unit_m();
  if (source.has_largest_extent_m()) options.largestExtent_m = source.largest_extent_m();
  const auto imported = importMesh(file, options);
  if (!imported) return tl::unexpected(imported.error());
  std::fprintf(stderr, "%s: %s\n", file.c_str(), imported->report.text().c_str());

  const ContentHash hash = hashOf(imported->mesh);
  const Interrupt interrupt;
  const auto finished = std::make_shared<std::promise<v1::AssetUploadReply>>();
  connection.link().upload(
      encodeMesh(imported->mesh),
      {[name](std::uint64_t sent_bytes, std::uint64_t total_bytes) { showProgress(name, sent_bytes, total_bytes); },
       [finished](const v1::AssetUploadReply& reply) { finished->set_value(reply); }});
  const auto reply = connection.await(finished->get_future(), [&] {
    if (Interrupt::interrupted()) connection.link().cancelUpload(hash);
  });
  endProgress();
  if (Interrupt::interrupted()) return refused(file.string(), "the upload was cancelled; nothing was changed");
  if (!reply) return tl::unexpected(reply.error());
  if (!reply->accepted()) return refused(file.string() + ": " + reply->field(), reply->reason());
  source.Clear();
  source.set_asset(hash.asBytes());
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

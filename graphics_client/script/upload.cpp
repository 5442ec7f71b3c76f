#include "graphics_client/script/upload.h"

#include <atomic>
#include <cstdio>
#include <future>
#include <memory>
#include <set>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/text/printable.h"
#include "graphics_client/editing/local_asset.h"
#include "graphics_client/editing/named_assets.h"
#include "graphics_client/editing/scene_file.h"
#include "graphics_client/script/interrupt.h"
#include "graphics_client/script/progress_bar.h"

namespace haptics {
namespace {

constexpr double kMegabyte = 1e6;
/// Of an upload, by a slow server: it says nothing of it until it is built.
constexpr double kBuilt_bytes_per_s = 1e6;

void showUpload(const std::string& name, std::uint64_t sent_bytes, std::uint64_t total_bytes) {
  char total[32];
  std::snprintf(total, sizeof total, "of %.1f MB ", static_cast<double>(total_bytes) / kMegabyte);
  showProgress("uploading " + name, static_cast<double>(sent_bytes) / static_cast<double>(total_bytes), total);
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
  auto sent = forEachReference(transaction, [&](AssetReference& reference) -> Result<void> {
    const auto given = files.find(reference.file());
    if (given == files.end()) return {};
    used.insert(given->first);
    auto file = readNamedFile(reference, given->second);
    if (!file) return tl::unexpected(std::move(file).error());
    std::fprintf(stderr, "%s: %s\n", given->second.c_str(), printable(file->report).c_str());
    const ContentHash hash = file->asset.hash;
    auto uploaded = uploadOne(connection, given->first, given->second, std::move(file->asset));
    if (uploaded) reference.setAsset(hash);
    return uploaded;
  });
  if (!sent) return sent;
  for (const auto& [name, file] : files) {
    if (!used.contains(name)) return refused("--upload " + name, "nothing in the scene names this file");
  }
  return {};
}

Result<void> uploadBeside(Connection& connection, const std::filesystem::path& scene, v1::Transaction& transaction,
                          const SceneVersion& present) {
  std::set<AssetName> held = assetsNamedBy(present);
  return takeFilesBeside(scene, transaction, [&](const std::string& name, LocalFile file) -> Result<void> {
    if (!held.insert({file.asset.kind, file.asset.hash}).second) return {};
    std::fprintf(stderr, "%s: %s\n", printable(name).c_str(), printable(file.report).c_str());
    return uploadOne(connection, name, scene.parent_path() / name, std::move(file.asset));
  });
}

}  // namespace haptics

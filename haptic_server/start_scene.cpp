#include "haptic_server/start_scene.h"

#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "common/log/log.h"
#include "common/wire/convert.h"
#include "haptic_server/watchdog/death_notice.h"

namespace haptics {

Result<void> loadScene(SceneService& sceneService, const std::string& file) {
  if (file.empty()) return {};
  auto message = readSceneFile(file);
  if (!message) return tl::unexpected(message.error());
  auto transaction = fromWire(*message);
  if (!transaction) return tl::unexpected(std::move(transaction.error()).within(file + ": "));
  auto reports = sceneService.loadStartScene(*transaction);
  if (!reports) return tl::unexpected(std::move(reports.error()).within(file + ": "));
  return {};
}

namespace {

void noteWork(SceneService& sceneService, const std::filesystem::path& file) {
  auto notes = WorkNotes::open(file);
  if (!notes) return logWarning(file.string() + " cannot be had: an edit that ends the server may do so again");
  if (const std::size_t count = notes->diedAt().size(); count > 0) {
    logWarning("the last server died while it was at " + std::to_string(count) +
               " edits or uploads; sent again, they are refused");
  }
  setCrashFlag(&notes->crashFlag());
  sceneService.noteWorkIn(std::move(notes));
}

}  // namespace

Result<std::unique_ptr<StateFolder>> resumeState(SceneService& sceneService, const ServerOptions& options) {
  auto opened = StateFolder::open(options.state, newEpoch(), {.info = logInfo, .warning = logWarning});
  if (!opened) return tl::unexpected(std::move(opened.error()).within("--state "));
  auto& folder = *opened->folder;
  noteWork(sceneService, std::filesystem::path(options.state) / "at_work");
  const auto readAsset = [&folder](const ContentHash& hash) { return folder.readAsset(hash); };
  for (const std::string& remark : sceneService.resume(std::move(opened->state), readAsset, folder)) {
    logWarning("--state " + options.state + ": " + remark);
  }
  if (const auto revision = sceneService.history()->version.revision(); revision > 0) {
    logInfo("going on at revision " + std::to_string(revision) + " of " + options.state +
            (options.scene.empty() ? "" : "; " + options.scene + " is not loaded"));
  }
  return std::move(opened->folder);
}

std::unique_ptr<StateScrubber> scrubState(SceneService& sceneService, StateFolder& state, const std::string& folder) {
  const auto named = [&sceneService] {
    std::vector<ContentHash> assets;
    const auto history = sceneService.history();
    for (const auto& object : history->version.objects()) {
      for (const AssetName& asset : object->assets()) assets.push_back(asset.hash);
    }
    return assets;
  };
  const auto repair = [&sceneService, &state](const std::filesystem::path& file,
                                              const std::optional<ContentHash>& asset) {
    logWarning(file.string() + " is damaged or missing; it is written anew from memory");
    return sceneService.checkpoint([&state, asset] {
      if (asset) state.distrust(*asset);
    });
  };
  return std::make_unique<StateScrubber>(StateScrubber::Options{folder, named, repair});
}

}  // namespace haptics

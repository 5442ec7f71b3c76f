#pragma once

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "haptic_server/scene/sequencer.h"
#include "haptic_server/state/state_folder.h"
#include "tests/common/temporary_folder.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics::test {

/// A sequencer that keeps its edits in a folder, as a server does, from one start to the next.
class KeptScene {
 public:
  explicit KeptScene(const std::filesystem::path& folder, std::uint64_t freshEpoch = 1,
                     std::size_t checkpointAfter_bytes = 16U << 20) {
    const auto note = [this](const std::string& line) { said.push_back(line); };
    auto opened = StateFolder::open(folder, freshEpoch, {note, note, checkpointAfter_bytes});
    if (!opened) throw std::runtime_error(opened.error().text());
    folder_ = std::move(opened->folder);
    const auto read = [this](const AssetName& name) {
      return store_.internEncoded(name, folder_->readAsset(name.hash).value());
    };
    Sequencer::Assets assets;
    for (const auto& object : opened->state.history->version.objects()) {
      assets[object->id] = gatherAssets(*object, read).value();
    }
    sequencer.resume(std::move(opened->state), std::move(assets), *folder_);
  }

  [[nodiscard]] const SceneVersion& version() const { return sequencer.history()->version; }
  Accepted accept(SessionId session, std::uint64_t seq, const Transaction& transaction) {
    const auto outcome = sequencer.submit(session, seq, transaction);
    if (const auto* error = std::get_if<Error>(&outcome)) throw std::runtime_error(error->text());
    return std::get<Accepted>(outcome);
  }

  std::vector<std::string> said;  ///< Lines for the log.
  BoxResolver resolver;
  Sequencer sequencer{999, resolver};

 private:
  AssetStore store_;
  std::unique_ptr<StateFolder> folder_;
};

}  // namespace haptics::test

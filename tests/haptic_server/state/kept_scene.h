#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "haptic_server/scene/lost_parts.h"
#include "haptic_server/scene/sequencer.h"
#include "haptic_server/state/state_folder.h"
#include "tests/common/temporary_folder.h"
#include "tests/haptic_server/scene/scene_edits.h"

namespace haptics::test {

/// A sequencer that keeps its edits in a folder, as a server does, from one start to the next.
class KeptScene {
 public:
  using Around = std::function<std::unique_ptr<EditJournal>(EditJournal&)>;  ///< A journal that hands on to another.

  explicit KeptScene(const std::filesystem::path& folder, std::uint64_t freshEpoch = 1,
                     std::size_t checkpointAfter_bytes = 16U << 20, std::size_t reserve_bytes = 0,
                     std::shared_ptr<FileSystem> files = nullptr, const Around& around = {}) {
    const auto note = [this](const std::string& line) { said.push_back(line); };
    auto opened =
        StateFolder::open(folder, freshEpoch, {note, note, checkpointAfter_bytes, reserve_bytes, std::move(files)});
    if (!opened) throw std::runtime_error(opened.error().text());
    folder_ = std::move(opened->folder);
    const auto read = [this](const AssetName& name) -> Result<std::shared_ptr<const Asset>> {
      auto bytes = folder_->readAsset(name.hash);
      if (!bytes) return tl::unexpected(bytes.error());
      return resolver.store().internEncoded(name, *std::move(bytes));
    };
    RestoredState restored = restore(std::move(opened->state), read, resolver.store(), freshEpoch);
    said.insert(said.end(), restored.warnings.begin(), restored.warnings.end());
    if (around) around_ = around(*folder_);
    sequencer.resume(std::move(restored.state), std::move(restored.assets), around_ ? *around_ : *folder_);
    if (restored.changed) sequencer.checkpoint();
  }

  [[nodiscard]] const SceneVersion& version() const { return sequencer.history()->version; }
  Accepted accept(SessionId session, std::uint64_t seq, const Transaction& transaction) {
    const auto outcome = sequencer.submit(session, seq, transaction);
    if (const auto* error = std::get_if<Error>(&outcome)) throw std::runtime_error(error->text());
    return std::get<Accepted>(outcome);
  }

  void distrust(const ContentHash& asset) { folder_->distrust(asset); }

  std::vector<std::string> said;  ///< Lines for the log.
  BoxResolver resolver;
  Sequencer sequencer{999, resolver};

 private:
  std::unique_ptr<StateFolder> folder_;
  std::unique_ptr<EditJournal> around_;
};

}  // namespace haptics::test

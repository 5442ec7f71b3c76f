#pragma once

#include <memory>
#include <vector>

#include "common/error/error.h"
#include "haptic_server/scene/asset_store.h"
#include "haptic_server/scene/edit_memory.h"
#include "haptic_server/scene/scene_history.h"

namespace haptics {

/// All that a sequencer needs to go on where another one was, but for the assets that its version names.
struct SequencerState {
  std::shared_ptr<const SceneHistory> history;
  EditDeduplicator memory;
  ObjectId nextId = 1;  ///< The next object's.
  /// Objects of the version as they were before assets of theirs were lost (lost_parts.h).
  std::vector<std::shared_ptr<const ObjectRecord>> lost = {};
};

/// Keeps accepted edits beyond the process.
class EditJournal {
 public:
  using Edits = std::vector<std::shared_ptr<const AcceptedEdit>>;
  using Assets = std::vector<std::shared_ptr<const Asset>>;

  virtual ~EditJournal() = default;
  /// Called before anyone hears of the edits, which follow `before` in this order; `assets` are
  /// those of the objects that they changed, some of which may be known. Does not throw.
  /// @return Nothing when all of them are kept. Else none of them counts, and the error is the answer to each.
  [[nodiscard]] virtual Result<void> keep(const SequencerState& before, const Edits& edits, const Assets& assets) = 0;
  /// Any thread. An edit may soon name this asset: what keeping it takes may be done now, where that takes long. Does not
  /// throw.
  virtual void prepare([[maybe_unused]] const std::shared_ptr<const Asset>& asset) {}
  /// The scene is this state from now on, to which no edit led that was kept. What cannot be kept now is kept before
  /// the next edit is. Does not throw.
  virtual void resetTo(const SequencerState& state, const Assets& assets) = 0;
};

}  // namespace haptics

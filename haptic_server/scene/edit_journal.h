#pragma once

#include <memory>
#include <vector>

#include "common/error/error.h"
#include "haptic_server/scene/asset_store.h"
#include "haptic_server/scene/edit_memory.h"
#include "haptic_server/scene/scene_history.h"

namespace haptics {

/// All that a sequencer needs to go on where another one was, but for the meshes that its version names.
struct SequencerState {
  std::shared_ptr<const SceneHistory> history;
  EditMemory memory;
  ObjectId nextId = 1;  ///< The next object's.
};

/// Keeps accepted edits beyond the process.
class EditJournal {
 public:
  using Edits = std::vector<std::shared_ptr<const AcceptedEdit>>;
  using Meshes = std::vector<std::shared_ptr<const MeshAsset>>;

  virtual ~EditJournal() = default;
  /// Called before anyone hears of the edits, which follow `before` in this order; `meshes` are those that they brought
  /// into the scene. Does not throw.
  /// @return Nothing when all of them are kept. Else none of them counts, and the error is the answer to each.
  [[nodiscard]] virtual Result<void> keep(const SequencerState& before, const Edits& edits, const Meshes& meshes) = 0;
};

}  // namespace haptics

#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <variant>
#include <vector>

#include "common/scene/scene.h"
#include "haptic_server/scene/edit_memory.h"
#include "haptic_server/scene/mesh_resolver.h"
#include "haptic_server/scene/scene_history.h"

namespace haptics {

/// A precondition did not hold; nothing was changed.
struct EditConflict {
  std::vector<SceneVersion::Object> current;  ///< The objects of the failed preconditions that exist, as they stand.
  std::string reason;
};

/// Accepted (the edit, shared with the history), in conflict, or rejected with the bad field's path.
using EditOutcome = std::variant<std::shared_ptr<const AcceptedEdit>, EditConflict, Error>;

/// Puts all edits into one order and makes the scene's revisions: one per accepted transaction, all of its operations
/// or none. The same submissions give the same history. One thread; no clock, no sockets.
class Sequencer {
 public:
  Sequencer(std::uint64_t epoch, MeshResolver& meshes);

  /// An edit that was accepted before is answered again with the same revision and root and not applied again (with
  /// its objects and reports while the history still holds them). Conflicts and rejections are not remembered.
  EditOutcome submit(SessionId session, std::uint64_t clientSeq, const Transaction& transaction);

  [[nodiscard]] const std::shared_ptr<const SceneHistory>& history() const noexcept { return history_; }
  /// The mesh of an object of the current version.
  [[nodiscard]] const std::shared_ptr<const MeshAsset>& meshOf(ObjectId id) const { return meshes_.at(id); }

 private:
  MeshResolver& resolver_;
  std::shared_ptr<const SceneHistory> history_;
  std::map<ObjectId, std::shared_ptr<const MeshAsset>> meshes_;  // holds what the current version names
  EditMemory memory_;
  ObjectId nextId_ = 1;

  std::shared_ptr<const AcceptedEdit> applied(SessionId session, const EditMemory::Result& result) const;
};

}  // namespace haptics

#include "haptic_server/scene/scene_history.h"

namespace haptics {

std::shared_ptr<const AcceptedEdit> SceneHistory::find(std::uint64_t revision) const {
  if (edits.empty()) return nullptr;
  const std::uint64_t first = edits.front()->commit.revision;
  if (revision < first || revision - first >= edits.size()) return nullptr;
  return edits[revision - first];
}

bool SceneHistory::canResumeFrom(std::uint64_t itsEpoch, std::uint64_t revision, const ContentHash& root) const {
  if (itsEpoch != epoch || revision > version.revision()) return false;
  if (revision == version.revision()) return root == version.root();
  const auto next = find(revision + 1);
  return next && next->commit.prevRoot == root;
}

}  // namespace haptics

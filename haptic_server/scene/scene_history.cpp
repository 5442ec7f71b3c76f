#include "haptic_server/scene/scene_history.h"

#include <random>
#include <utility>

namespace haptics {

void SceneHistory::append(std::shared_ptr<const AcceptedEdit> edit, SceneVersion made, std::size_t remembered) {
  version = std::move(made);
  edits.push_back(std::move(edit));
  while (edits.size() > remembered) edits.pop_front();
}

std::shared_ptr<const AcceptedEdit> SceneHistory::find(std::uint64_t revision) const {
  if (edits.empty()) return nullptr;
  const std::uint64_t first = edits.front()->commit.revision;
  if (revision < first || revision - first >= edits.size()) return nullptr;
  return edits[revision - first];
}

std::optional<ContentHash> SceneHistory::rootAt(std::uint64_t revision) const {
  if (revision == version.revision()) return version.root();
  if (const auto next = find(revision + 1)) return next->commit.prevRoot;
  return std::nullopt;
}

bool SceneHistory::canResumeFrom(std::uint64_t itsEpoch, std::uint64_t revision, const ContentHash& root) const {
  return itsEpoch == epoch && rootAt(revision) == root;
}

std::uint64_t newEpoch() {
  std::random_device entropy;
  const std::uint64_t epoch = std::uint64_t{entropy()} << 32 | entropy();
  return epoch == 0 ? 1 : epoch;
}

}  // namespace haptics

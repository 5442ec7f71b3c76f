#include "tests/sim/disk.h"

#include <algorithm>
#include <memory>

namespace haptics::sim {

Result<void> Disk::keep(const SequencerState&, const Edits& edits, const Meshes& meshes) {
  const auto write = [this, edits, meshes] {
    edits_.insert(edits_.end(), edits.begin(), edits.end());
    meshes_.insert(meshes_.end(), meshes.begin(), meshes.end());
  };
  if (later_) {
    later_(write);
  } else {
    write();
  }
  return {};
}

SequencerState Disk::recovered(Mutant mutant) const {
  SceneHistory history{.epoch = epoch_, .version = {}, .edits = {}};
  SequencerState state;
  for (const auto& edit : edits_) {
    history.append(edit, history.version.apply(edit->commit).value());
    if (mutant != Mutant::kIdsReused) state.nextId = edit->nextId;
    if (mutant == Mutant::kDedupeLostAtRestart) continue;
    state.memory.remember(edit->session, {edit->clientSeq, edit->commit.revision, edit->commit.root});
  }
  if (mutant == Mutant::kIdsReused) {
    for (const auto& object : history.version.objects()) state.nextId = object->id + 1;
  }
  state.history = std::make_shared<const SceneHistory>(std::move(history));
  return state;
}

Sequencer::Meshes Disk::meshesOf(const SceneVersion& version) const {
  Sequencer::Meshes meshes;
  for (const auto& object : version.objects()) {
    const auto known = std::ranges::find(meshes_, object->mesh, [](const auto& mesh) { return mesh->hash; });
    if (known != meshes_.end()) meshes[object->id] = *known;
  }
  return meshes;
}

}  // namespace haptics::sim

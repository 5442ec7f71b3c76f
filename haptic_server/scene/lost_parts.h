#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "haptic_server/scene/edit_journal.h"
#include "haptic_server/scene/object_assets.h"
#include "haptic_server/scene/scene_draft.h"

// What becomes of a kept scene when files that it names are damaged or missing.
//
// An object without its mesh stays in the scene, as a small box in its place: its name, number, pose, stiffness, damping
// and colour are known, and clients may go on to edit, remesh or remove it. Dropping it would lose those too, without a
// reason. The box is a fixed, plain body: the record says nothing of how large the mesh was, and surface, motion
// and deformation were made for that mesh. A field, per-vertex values or moved vertices cost the property that needs
// them. The record as it was is remembered, so that the parts come back when their assets do.
namespace haptics {

inline constexpr double kPlaceholderSide_m = 0.02;

/// An object's record of what could be had, and that.
struct RecoveredObject {
  ObjectRecord record;
  ObjectAssets assets;
  std::vector<std::string> lost;  ///< `mesh: is missing`; empty: nothing.
};
/// The placeholder's mesh is made in the store.
[[nodiscard]] RecoveredObject recoverObject(ObjectRecord record, const AssetLookup& lookUp, AssetStore& store);

/// The object as it is with what it has lost since it was `before`, unless edits have put something in its place.
[[nodiscard]] ObjectRecord withLostParts(const ObjectRecord& now, const ObjectRecord& before);
/// "mesh", "texture": what withLostParts() would bring back.
[[nodiscard]] std::vector<std::string> lostParts(const ObjectRecord& now, const ObjectRecord& before);
/// The lost records from which withLostParts() can still restore a part.
[[nodiscard]] std::vector<std::shared_ptr<const ObjectRecord>> stillLost(const SequencerState& state);

/// A kept state whose assets are all here.
struct RestoredState {
  SequencerState state;
  SceneDraft::Assets assets;
  std::vector<std::string> warnings;  ///< One for each part that is lost or here again, with the object's name.
  bool changed = false;               ///< Objects are not what they were: a revision of the server's own says so.
};
/// With every asset that can be had. When something was lost the state is of `freshEpoch`: clients get a snapshot and
/// learn of it, in place of one revision among others. A state that only gets back what it had lost goes on in its epoch.
[[nodiscard]] RestoredState restore(SequencerState state, const AssetLookup& lookUp, AssetStore& store,
                                    std::uint64_t freshEpoch);

}  // namespace haptics

#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "common/scene/scene.h"
#include "haptic_server/engine/step/servo_scene.h"
#include "haptic_server/scene/asset_resolver.h"
#include "haptic_server/scene/driven_shape.h"
#include "haptic_server/scene/edit_journal.h"
#include "haptic_server/scene/scene_draft.h"

namespace haptics {

/// An edit as it comes from a client.
struct Submission {
  SessionId session = kServerSession;
  std::uint64_t clientSeq = 0;
  Transaction transaction;
};

/// A precondition did not hold; nothing was changed.
struct EditConflict {
  std::vector<SceneVersion::Object> current;  ///< The objects of the failed preconditions that exist, as they stand.
  std::string reason;
};

/// Accepted (the edit, shared with the history), in conflict, or rejected with the bad field's path.
using EditOutcome = std::variant<std::shared_ptr<const AcceptedEdit>, EditConflict, Error>;
/// Of several edits, in their order; none where what takes long of one of them is to be prepared first.
using EditOutcomes = std::optional<std::vector<EditOutcome>>;

/// Puts all edits into one order and makes the scene's revisions: one per accepted transaction, all of its operations
/// or none. The same submissions give the same history. One thread; no clock, no sockets.
class Sequencer {
 public:
  using Assets = SceneDraft::Assets;

  Sequencer(std::uint64_t epoch, AssetResolver& resolver, const SceneLimits& limits = {});

  /// Goes on from an earlier sequencer's state, with the assets of its objects; from now on every accepted edit is kept
  /// by the journal before it counts. Instead of all that was submitted so far.
  void resume(SequencerState state, Assets assets, EditJournal& journal);

  /// The scene is this version from now on, which was made elsewhere, with the assets of its objects. One that is no
  /// single revision further than the last, or too much for one commit, begins a new epoch.
  void show(const SceneVersion& version, Assets assets);

  /// Decides the edits in this order, as if one by one; the journal keeps them together. One that was accepted before
  /// is answered again with the same revision and root and not applied again (with its objects and reports while the
  /// history still holds them). Conflicts and rejections are not remembered,
  /// but one that a later edit of its session has passed over is never applied: a session's edits keep their order.
  /// @return None, and all is as it was, where the resolver needs preparation.
  /// \param resolver  Instead of the sequencer's own.
  EditOutcomes submit(std::span<const Submission> submissions, AssetResolver& resolver) {
    return submit(submissions, resolver, journal_);
  }
  std::vector<EditOutcome> submit(std::span<const Submission> submissions) {
    return submit(submissions, resolver_).value();
  }
  EditOutcome submit(SessionId session, std::uint64_t clientSeq, const Transaction& transaction);
  /// Whether submit() answers it by what was decided before.
  [[nodiscard]] bool isKnown(const Submission& submission) const { return answeredBefore(submission).has_value(); }
  /// Applies an edit of the server's own that counts even if it cannot be kept now: it is kept before the next one is.
  EditOutcome submitOwn(const Submission& submission);
  void checkpoint();  ///< The journal keeps the present state, to which no edits led that it knows, as soon as it can.
  /// A revision of the server's own in which objects of the version are these, with their assets. Refused: it cannot be
  /// kept.
  [[nodiscard]] Result<void> replaceObjects(std::vector<ObjectRecord> objects, const Assets& assets);

  [[nodiscard]] const std::shared_ptr<const SceneHistory>& history() const noexcept { return state_.history; }
  [[nodiscard]] const SequencerState& state() const noexcept { return state_; }
  /// The scene by which edits are decided.
  struct Scene {
    std::shared_ptr<const SceneHistory> history;
    Assets assets;
    ObjectId nextId;
    SceneLimits limits;
  };
  [[nodiscard]] Scene scene() const { return {state_.history, assets_, state_.nextId, limits_}; }
  /// Assets of an object of the current version.
  [[nodiscard]] const ObjectAssets& assetsOf(ObjectId id) const { return assets_.at(id); }
  /// The revision that last set the object's pose, 0 when that was before this sequencer.
  [[nodiscard]] std::uint64_t posedAt(ObjectId id) const;
  /// Where the object is driven, apart from the scene (SetPose::kinematic).
  [[nodiscard]] KinematicPose kinematicOf(ObjectId id) const;
  /// The same of its vertices (SetDeformation::kinematic).
  using DrivenShapes = std::map<ObjectId, DrivenShape>;
  [[nodiscard]] const DrivenShapes& drivenShapes() const noexcept { return driven_.shapes; }
  [[nodiscard]] std::uint64_t kinematicSamples() const noexcept { return driven_.samples; }  ///< So far.

 private:
  /// Objects that are driven. No part of what is kept: after a restart objects are where the scene has them.
  struct Driven {
    std::map<ObjectId, KinematicPose> newest;
    DrivenShapes shapes;
    std::uint64_t samples = 0;  // of both: at least each shape's number
  };
  /// The state after edits that the journal has not kept yet.
  struct Batch {
    SceneHistory history;
    Assets assets;
    ObjectId nextId;
    std::size_t remembered;  // edits
    EditJournal::Edits edits;
    EditJournal::Assets newAssets;
    std::vector<std::pair<ObjectId, std::uint64_t>> posedAt;
    Driven driven;

    void take(const std::shared_ptr<const AcceptedEdit>& edit, SceneVersion made, const Assets& newOnes,
              const std::set<ObjectId>& posed, const std::set<ObjectId>& reshaped) noexcept;
  };
  AssetResolver& resolver_;
  const SceneLimits limits_;
  EditJournal* journal_ = nullptr;
  SequencerState state_;
  Assets assets_;  // holds what the current version names
  std::map<ObjectId, std::uint64_t> posedAt_;
  Driven driven_;

  EditOutcomes submit(std::span<const Submission> submissions, AssetResolver& resolver, EditJournal* journal);
  Result<void> checkAnswer(const AcceptedEdit& edit) const;
  static Result<void> checkDriven(const SceneVersion& next, const Driven& driven, const std::set<ObjectId>& posed);
  static Result<void> checkReadable(const AcceptedEdit& edit);
  std::optional<EditOutcome> answeredBefore(const Submission& submission) const;
  EditOutcome decide(const Submission& submission, Batch& batch, AssetResolver& resolver) const;
  EditOutcome drive(const Submission& submission, Batch& batch) const;
  static Result<void> drive(const ObjectRecord& object, const SetPose& set, Driven& driven);
  Result<void> drive(const ObjectRecord& object, const SetDeformation& set, Driven& driven, const Batch& batch) const;
  void adopt(Batch&& batch) noexcept;
};

}  // namespace haptics

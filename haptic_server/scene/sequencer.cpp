#include "haptic_server/scene/sequencer.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "haptic_server/scene/scene_draft.h"

namespace haptics {
namespace {

SceneVersion::Object find(const SceneVersion& version, const ObjectRef& ref) {
  const auto* id = std::get_if<ObjectId>(&ref.value);
  return id ? version.find(*id) : version.find(std::get<std::string>(ref.value));
}

/// Why the precondition does not hold for the object as it stands; empty when it does.
std::string failure(const Precondition& precondition, const SceneVersion::Object& object) {
  if (!object) return precondition.object.text() + " is not there";
  if (object->revision != precondition.expectedRevision) {
    return precondition.object.text() + " stands at revision " + std::to_string(object->revision) + ", expected was " +
           std::to_string(precondition.expectedRevision);
  }
  if (precondition.expectedHash && *precondition.expectedHash != object->hash()) {
    return precondition.object.text() + " has another hash than expected";
  }
  return {};
}

std::optional<EditConflict> conflictOf(const SceneVersion& version, const std::vector<Precondition>& preconditions) {
  EditConflict conflict;
  for (const Precondition& precondition : preconditions) {
    const auto object = find(version, precondition.object);
    const std::string why = failure(precondition, object);
    if (why.empty()) continue;
    if (conflict.reason.empty()) conflict.reason = why;
    if (object && std::ranges::find(conflict.current, object) == conflict.current.end()) {
      conflict.current.push_back(object);
    }
  }
  if (conflict.reason.empty()) return std::nullopt;
  return conflict;
}

}  // namespace

Sequencer::Sequencer(std::uint64_t epoch, MeshResolver& meshes) : resolver_(meshes) {
  history_ = std::make_shared<const SceneHistory>(SceneHistory{.epoch = epoch, .version = {}, .edits = {}});
}

EditOutcome Sequencer::submit(SessionId session, std::uint64_t clientSeq, const Transaction& transaction) {
  if (clientSeq == 0) return Error{"client_seq", "is 0; it counts up from 1"};
  const auto known = memory_.find(session, clientSeq);
  if (known.answer == EditMemory::Answer::kApplied) return applied(session, known.result);
  if (known.answer == EditMemory::Answer::kForgotten) {
    return Error{"client_seq", "is so far behind the session's newest edits that it may have been applied already"};
  }
  if (transaction.operations.empty()) return Error{"operations", "is empty; an edit has at least one operation"};

  const SceneVersion& base = history_->version;
  if (auto conflict = conflictOf(base, transaction.preconditions)) return *std::move(conflict);

  SceneDraft draft(base, nextId_);
  for (std::size_t i = 0; i < transaction.operations.size(); ++i) {
    const auto done = draft.apply(transaction.operations[i], "operations[" + std::to_string(i) + "].");
    if (!done) return done.error();
  }
  auto reports = draft.resolveMeshes(resolver_);
  if (!reports) return std::move(reports).error();

  auto edit = std::make_shared<AcceptedEdit>(AcceptedEdit{session, clientSeq, draft.commit(), *std::move(reports)});
  auto next = base.apply(edit->commit);
  if (!next) return std::move(next).error();
  edit->commit.root = next->root();

  auto history = std::make_shared<SceneHistory>(*history_);
  history->version = *std::move(next);
  history->edits.push_back(edit);
  if (history->edits.size() > kRememberedEdits) history->edits.pop_front();

  for (const ObjectId id : edit->commit.removed) meshes_.erase(id);
  for (const auto& [id, asset] : draft.meshes()) meshes_[id] = asset;
  nextId_ = draft.nextId();
  memory_.remember(session, {clientSeq, edit->commit.revision, edit->commit.root});
  history_ = std::move(history);
  return edit;
}

std::shared_ptr<const AcceptedEdit> Sequencer::applied(SessionId session, const EditMemory::Result& result) const {
  if (auto edit = history_->find(result.revision)) return edit;
  auto edit = std::make_shared<AcceptedEdit>();
  edit->session = session;
  edit->clientSeq = result.clientSeq;
  edit->commit.revision = result.revision;
  edit->commit.root = result.root;
  return edit;
}

}  // namespace haptics

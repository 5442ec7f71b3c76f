#include "haptic_server/scene/sequencer.h"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <string>

#include "common/wire/convert.h"

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

/// The commit that leads from one version to another.
Commit difference(const SceneVersion& before, const SceneVersion& after) {
  Commit commit{
      .revision = after.revision(), .prevRoot = before.root(), .put = {}, .removed = {}, .root = after.root()};
  for (const auto& object : after.objects()) {
    const auto known = before.find(object->id);
    if (!known || !(*known == *object)) commit.put.push_back(*object);
  }
  for (const auto& object : before.objects()) {
    if (!after.find(object->id)) commit.removed.push_back(object->id);
  }
  return commit;
}

/// Moves without a revision.
[[nodiscard]] bool isKinematic(const Operation& operation) {
  return std::visit(
      [](const auto& set) {
        if constexpr (requires { set.kinematic; }) return set.kinematic;
        return false;
      },
      operation);
}

/// A sample of a driven shape has a lattice and nothing else.
[[nodiscard]] Result<void> checkShape(const DeformationEdit& edit) {
  if (edit.lattice && *edit.lattice && !edit.softness && !edit.residue) return {};
  return refused("deformation", "has a lattice, which is not empty, and nothing else where kinematic is set");
}

[[nodiscard]] bool isTool(const SceneVersion::Object& object) { return object->motion && object->motion->tool; }

/// What an edit is answered that changes nothing of the scene.
[[nodiscard]] std::shared_ptr<const AcceptedEdit> withoutRevision(const Submission& submission,
                                                                  const SceneVersion& version) {
  auto edit = std::make_shared<AcceptedEdit>();
  edit->session = submission.session;
  edit->clientSeq = submission.clientSeq;
  edit->commit.revision = version.revision();
  edit->commit.root = version.root();
  return edit;
}

/// An edit that was refused before a later one of its session was accepted, and whose answer was lost. Applied now, it
/// would take effect out of order.
EditOutcome superseded(const SceneVersion& version, const Submission& submission) {
  if (auto conflict = conflictOf(version, submission.transaction.preconditions)) return *std::move(conflict);
  return Error{"client_seq", "was refused before, and later edits of this session were accepted since"};
}

}  // namespace

Sequencer::Sequencer(std::uint64_t epoch, AssetResolver& resolver, const SceneLimits& limits)
    : resolver_(resolver), limits_(limits) {
  state_.history = std::make_shared<const SceneHistory>(SceneHistory{.epoch = epoch, .version = {}, .edits = {}});
}

void Sequencer::resume(SequencerState state, Assets assets, EditJournal& journal) {
  state_ = std::move(state);
  assets_ = std::move(assets);
  journal_ = &journal;
}

void Sequencer::show(const SceneVersion& version, Assets assets) {
  if (version.root() == state_.history->version.root()) return;
  SceneHistory history = *state_.history;
  const auto append = [&history](const SceneVersion& to) {
    auto edit = std::make_shared<AcceptedEdit>();
    edit->commit = difference(history.version, to);
    history.append(edit, to);
  };
  // Revisions that no servo took up: who watches goes through each.
  const std::uint64_t last = std::min(version.revision(), history.version.revision() + limits_.remembered_edits);
  while (history.version.revision() + 1 < last)
    append(*history.version.apply({.revision = history.version.revision() + 1}));
  const Commit commit = difference(history.version, version);
  const auto next = history.version.apply(commit);
  if (answerSizeOf(commit, {}) <= limits_.answer_bytes && next && next->root() == version.root()) {
    append(version);
  } else {
    history = {.epoch = newEpoch(), .version = version, .edits = {}};
  }
  state_.history = std::make_shared<const SceneHistory>(std::move(history));
  assets_ = std::move(assets);
}

KinematicPose Sequencer::kinematicOf(ObjectId id) const {
  const auto at = driven_.newest.find(id);
  return at == driven_.newest.end() ? KinematicPose{} : at->second;
}

std::uint64_t Sequencer::posedAt(ObjectId id) const {
  const auto at = posedAt_.find(id);
  return at == posedAt_.end() ? 0 : at->second;
}

EditOutcome Sequencer::submit(SessionId session, std::uint64_t clientSeq, const Transaction& transaction) {
  const Submission submission{session, clientSeq, transaction};
  return submit(std::span(&submission, 1)).front();
}

EditOutcomes Sequencer::submit(std::span<const Submission> submissions, AssetResolver& resolver, EditJournal* journal) {
  Batch batch{*state_.history, assets_, state_.nextId, limits_.remembered_edits, {}, {}, {}, driven_};
  std::vector<EditOutcome> outcomes;
  std::vector<std::size_t> unkept;  // outcomes that rest on the batch
  for (const Submission& submission : submissions) {
    if (auto known = answeredBefore(submission)) {
      outcomes.push_back(*std::move(known));
      continue;
    }
    try {
      outcomes.push_back(decide(submission, batch, resolver));
    } catch (const std::exception& failure) {
      outcomes.emplace_back(Error{"", std::string("the server could not carry out the edit: ") + failure.what()});
    }
    if (resolver.needsPreparation()) return std::nullopt;
    if (std::holds_alternative<std::shared_ptr<const AcceptedEdit>>(outcomes.back()) || !batch.edits.empty())
      unkept.push_back(outcomes.size() - 1);
  }
  if (batch.edits.empty()) {
    driven_ = std::move(batch.driven);
    return outcomes;
  }
  if (journal) {
    if (const auto kept = journal->keep(state_, batch.edits, batch.newAssets); !kept) {
      for (const std::size_t i : unkept) outcomes[i] = kept.error();
      return outcomes;
    }
  }
  adopt(std::move(batch));
  return outcomes;
}

EditOutcome Sequencer::submitOwn(const Submission& submission) {
  auto outcome = submit(std::span(&submission, 1), resolver_, nullptr)->front();
  if (journal_ && std::holds_alternative<std::shared_ptr<const AcceptedEdit>>(outcome)) checkpoint();
  return outcome;
}

void Sequencer::checkpoint() {
  EditJournal::Assets held;
  for (const auto& [id, assets] : assets_) {
    held.push_back(assets.mesh);
    held.insert(held.end(), assets.others.begin(), assets.others.end());
  }
  journal_->resetTo(state_, held);
}

Result<void> Sequencer::replaceObjects(std::vector<ObjectRecord> objects, const Assets& assets) {
  Batch batch{*state_.history, assets_, state_.nextId, limits_.remembered_edits, {}, {}, {}, driven_};
  const SceneVersion& base = batch.history.version;
  Commit commit{
      .revision = base.revision() + 1, .prevRoot = base.root(), .put = std::move(objects), .removed = {}, .root = {}};
  auto next = base.apply(commit);
  if (!next) return tl::unexpected(std::move(next).error());
  commit.root = next->root();
  const std::uint64_t revision = commit.revision;
  const auto edit = std::make_shared<const AcceptedEdit>(
      AcceptedEdit{kServerSession, revision, std::move(commit), {}, state_.nextId});
  std::set<ObjectId> reshaped;
  for (const auto& [id, held] : assets) reshaped.insert(id);
  batch.take(edit, *std::move(next), assets, {}, reshaped);
  if (journal_) {
    if (auto kept = journal_->keep(state_, batch.edits, batch.newAssets); !kept) return kept;
  }
  adopt(std::move(batch));
  return {};
}

std::optional<EditOutcome> Sequencer::answeredBefore(const Submission& submission) const {
  if (submission.clientSeq == 0) return Error{"client_seq", "is 0; it counts up from 1"};
  const auto known = state_.memory.find(submission.session, submission.clientSeq);
  if (known.answer == EditDeduplicator::Answer::kNew) return std::nullopt;
  const auto& operations = submission.transaction.operations;
  if (!operations.empty() && std::ranges::all_of(operations, isKinematic))
    return withoutRevision(submission, state_.history->version);  // later edits have passed over it
  if (known.answer == EditDeduplicator::Answer::kSuperseded) return superseded(state_.history->version, submission);
  if (known.answer == EditDeduplicator::Answer::kForgotten) {
    return Error{"client_seq", "is so far behind the session's newest edits that it may have been applied already"};
  }
  if (auto edit = state_.history->find(known.result.revision)) return edit;
  auto edit = std::make_shared<AcceptedEdit>();
  edit->session = submission.session;
  edit->clientSeq = submission.clientSeq;
  edit->commit.revision = known.result.revision;
  edit->commit.root = known.result.root;
  return edit;
}

EditOutcome Sequencer::decide(const Submission& submission, Batch& batch, AssetResolver& resolver) const {
  const auto& [session, clientSeq, transaction] = submission;
  const SceneVersion& base = batch.history.version;
  for (const auto& edit : batch.edits) {
    if (edit->session == session && edit->clientSeq == clientSeq) return edit;
    if (edit->session == session && edit->clientSeq > clientSeq) return superseded(base, submission);
  }
  if (transaction.operations.empty()) return Error{"operations", "is empty; an edit has at least one operation"};

  if (auto conflict = conflictOf(base, transaction.preconditions)) return *std::move(conflict);
  if (std::ranges::any_of(transaction.operations, isKinematic)) return drive(submission, batch);

  SceneDraft draft(base, batch.assets, batch.nextId, limits_);
  for (std::size_t i = 0; i < transaction.operations.size(); ++i) {
    const auto done = draft.apply(transaction.operations[i], "operations[" + std::to_string(i) + "].");
    if (!done) return done.error();
  }
  auto reports = draft.resolve(resolver);
  if (!reports) return std::move(reports).error();

  auto edit = std::make_shared<AcceptedEdit>(
      AcceptedEdit{session, clientSeq, draft.commit(), *std::move(reports), draft.nextId()});
  auto next = base.apply(edit->commit);
  if (!next) return std::move(next).error();
  edit->commit.root = next->root();
  if (auto fits = checkDriven(*next, batch.driven, draft.posed()); !fits) return std::move(fits).error();
  if (auto fits = checkReadable(*edit); !fits) return std::move(fits).error();
  if (auto fits = checkAnswer(*edit); !fits) return std::move(fits).error();

  batch.take(edit, *std::move(next), draft.assets(), draft.posed(), draft.reshaped());
  return edit;
}

/// Objects that move by themselves, and those that go on being driven, are no more than the step has room for.
Result<void> Sequencer::checkDriven(const SceneVersion& next, const Driven& driven, const std::set<ObjectId>& posed) {
  if (driven.newest.empty()) return {};
  std::size_t count = 0;
  for (const auto& object : next.objects()) {
    const bool isDriven = driven.newest.contains(object->id) && !posed.contains(object->id);
    count += object->movesByItself() || isDriven ? 1 : 0;
  }
  if (count <= kMaxMovingBodies) return {};
  return refused("operations", "leave " + std::to_string(count) + " objects that move or are driven; at most " +
                                   std::to_string(kMaxMovingBodies) + " of a scene may");
}

/// Clients and the journal can read again what the edit makes of its objects.
Result<void> Sequencer::checkReadable(const AcceptedEdit& edit) {
  for (const ObjectRecord& record : edit.commit.put) {
    v1::ObjectState message;
    toWire(record, message);
    if (const auto again = fromWire(message); !again)
      return refused("operations",
                     "make \"" + record.name + "\" an object of which nobody can read " + again.error().text());
  }
  return {};
}

EditOutcome Sequencer::drive(const Submission& submission, Batch& batch) const {
  const SceneVersion& base = batch.history.version;
  Driven driven = batch.driven;
  const auto& operations = submission.transaction.operations;
  for (std::size_t i = 0; i < operations.size(); ++i) {
    const std::string field = "operations[" + std::to_string(i) + "].";
    if (!isKinematic(operations[i]))
      return Error{"operations[" + std::to_string(i) + "]",
                   "stands beside one with kinematic: true; an edit has only such operations, or none"};
    SceneDraft draft(base, batch.assets, batch.nextId, limits_);
    if (auto known = draft.apply(operations[i], field); !known) return std::move(known).error();
    const ObjectRecord& object = *base.find(draft.objects().front().id);
    const auto* pose = std::get_if<SetPose>(&operations[i]);
    auto done = pose != nullptr ? drive(object, *pose, driven)
                                : drive(object, std::get<SetDeformation>(operations[i]), driven, batch);
    if (!done) return std::move(done).error().within(field + (pose != nullptr ? "set_pose." : "set_deformation."));
  }
  if (auto fits = checkDriven(base, driven, {}); !fits) return std::move(fits).error();
  batch.driven = std::move(driven);
  return withoutRevision(submission, base);
}

Result<void> Sequencer::drive(const ObjectRecord& object, const SetPose& set, Driven& driven) {
  if (object.movesByItself()) {
    return refused("kinematic", "is for objects without a motion, or a fixed one; \"" + object.name +
                                    "\" moves by itself: an empty set_motion ends that");
  }
  const auto last = driven.newest.find(object.id);
  const Pose from = last == driven.newest.end() ? object.pose : last->second.pose;
  driven.newest[object.id] = {++driven.samples, edited(from, set.pose), kFirstSample_s};
  return {};
}

/// Samples that come before the last one was given to the servo take its place.
Result<void> Sequencer::drive(const ObjectRecord& object, const SetDeformation& set, Driven& driven,
                              const Batch& batch) const {
  if (auto fits = checkShape(set.deformation); !fits) return fits;
  if (const auto why = whyNotReshaped(object))
    return refused("kinematic", "is not for \"" + object.name + "\", which " + *why);
  if (std::ranges::any_of(batch.history.version.objects(), isTool))
    return refused("kinematic", "is not for scenes with a tool in the hand, which would not feel the vertices move");
  const ObjectAssets& assets = batch.assets.at(object.id);
  std::size_t triangles = assets.mesh->mesh->triangles.size();
  for (const auto& [id, shape] : driven.shapes)
    triangles += id == object.id ? 0 : batch.assets.at(id).mesh->mesh->triangles.size();
  if (triangles > limits_.driven_triangles) {
    return refused("kinematic", "drives the vertices of " + std::to_string(triangles) + " triangles; at most " +
                                    std::to_string(limits_.driven_triangles) + " of a scene can be driven");
  }
  auto sample = shapeSample(object, assets, **set.deformation.lattice, set.deformation.latticeOfMesh);
  if (!sample) return tl::unexpected(std::move(sample.error()).within("deformation."));
  ++driven.samples;
  DrivenShape& shape = driven.shapes[object.id];
  const auto given = driven_.shapes.find(object.id);
  const bool isGiven = given != driven_.shapes.end() && given->second.number == shape.number;
  const bool begins = shape.number == 0;
  if (begins) {
    shape.number = driven.samples - 1;
    shape.samples.push_back(std::make_shared<const DrivenShape::Sample>(ownShape(object, assets)));
  }
  shape.take(std::make_shared<const DrivenShape::Sample>(*std::move(sample)), begins || isGiven);
  return {};
}

/// A start scene is sent to nobody as a commit: its objects only need to fit one by one.
Result<void> Sequencer::checkAnswer(const AcceptedEdit& edit) const {
  const std::size_t bytes = answerSizeOf(edit.commit, edit.reports);
  if (bytes <= limits_.answer_bytes) return {};
  const std::string right = " bytes; the answer to an edit holds " + std::to_string(limits_.answer_bytes);
  for (const ObjectRecord& record : edit.commit.put) {
    if (const std::size_t its = wireSizeOf(record); its > limits_.answer_bytes) {
      return refused("operations",
                     "make object \"" + record.name + "\" " + std::to_string(its) + right + ": give it less detail");
    }
  }
  if (edit.session == kServerSession) return {};
  return refused("operations", "change objects whose states take " + std::to_string(bytes) + right +
                                   ": change fewer of them in one edit");
}

/// Whole or not at all: without the memory for it the process ends.
void Sequencer::Batch::take(const std::shared_ptr<const AcceptedEdit>& edit, SceneVersion made, const Assets& newOnes,
                            const std::set<ObjectId>& posed, const std::set<ObjectId>& reshaped) noexcept {
  for (const ObjectId id : edit->commit.removed) assets.erase(id);
  for (const ObjectId id : posed) posedAt.emplace_back(id, edit->commit.revision);
  std::erase_if(driven.newest, [&](const auto& entry) {
    const auto object = made.find(entry.first);
    return !object || object->movesByItself() || posed.contains(entry.first);
  });
  const bool anyTool = std::ranges::any_of(made.objects(), isTool);
  std::erase_if(driven.shapes, [&](const auto& entry) {
    const auto object = made.find(entry.first);
    return anyTool || !object || whyNotReshaped(*object) || reshaped.contains(entry.first);
  });
  for (const auto& [id, held] : newOnes) {
    assets[id] = held;
    newAssets.push_back(held.mesh);
    newAssets.insert(newAssets.end(), held.others.begin(), held.others.end());
  }
  nextId = edit->nextId;
  edits.push_back(edit);
  history.append(edit, std::move(made), remembered);
}

/// The journal has the edits already: without the memory to follow it the process ends, and goes on from there.
void Sequencer::adopt(Batch&& batch) noexcept {
  for (const auto& edit : batch.edits) {
    state_.memory.remember(edit->session, {edit->clientSeq, edit->commit.revision, edit->commit.root});
  }
  state_.history = std::make_shared<const SceneHistory>(std::move(batch.history));
  state_.nextId = batch.nextId;
  for (const auto& [id, revision] : batch.posedAt) posedAt_[id] = revision;
  std::erase_if(posedAt_, [this](const auto& entry) { return !state_.history->version.find(entry.first); });
  assets_ = std::move(batch.assets);
  driven_ = std::move(batch.driven);
}

}  // namespace haptics

#include "graphics_client/editing/edit_history.h"

#include <algorithm>
#include <utility>

#include "common/wire/convert.h"

namespace haptics {
namespace {

/// Adds what of these assets the view holds.
void gather(const MirrorView& view, const std::set<AssetName>& names, NamedAssets& assets) {
  for (const AssetName& name : names) {
    if (auto content = view.contentOf(name)) assets.emplace(name, *std::move(content));
  }
}

std::set<AssetName> assetsOf(const SceneVersion::Object& object) {
  if (!object) return {};
  const auto names = object->assets();
  return {names.begin(), names.end()};
}

/// Named before or after the changes, not both: an object names the others while the changes can be undone or redone.
std::set<AssetName> changedAssets(const Changes& changes) {
  std::set<AssetName> names;
  for (const ObjectChange& change : changes) {
    const auto before = assetsOf(change.before), after = assetsOf(change.after);
    std::ranges::set_symmetric_difference(before, after, std::inserter(names, names.end()));
  }
  return names;
}

/// The object after the edit, null where it is removed. Nothing: neither the reply nor the mirror tells.
std::optional<SceneVersion::Object> objectAfter(const EditedObject& edited, const v1::Accepted& accepted,
                                                const MirrorView& view) {
  if (edited.isRemoved) return nullptr;
  for (const v1::ObjectState& state : accepted.object()) {
    if (state.name() != edited.name) continue;
    auto record = fromWire(state);
    if (!record) return std::nullopt;
    return std::make_shared<const ObjectRecord>(*std::move(record));
  }
  if (view.scene->revision() < accepted.revision()) return std::nullopt;
  return view.scene->find(edited.name);
}

}  // namespace

void EditHistory::submit(Edit edit, EditDone done) {
  auto entry = std::make_shared<Entry>();
  entry->text = edit.text;
  entry->group = edit.group;
  unanswered_.push_back(entry);
  Waiting waiting{.go = {}, .of = edit.of, .isComposed = edit.compose != nullptr, .group = edit.group};
  for (const EditedObject& object : objectsEditedBy(edit.transaction, *port_.view()->scene)) {
    waiting.of.insert(object.name);
  }
  waiting.go = [this, edit = std::move(edit), of = waiting.of, entry, done = std::move(done)] {
    begin(edit, of, entry, done);
  };
  // Further values of a drag that is to be undone are part of what is undone.
  const auto before = std::ranges::find_if(waiting_, [&edit = waiting](const Waiting& other) {
    return other.isTurn && edit.group != 0 && other.group == edit.group;
  });
  waiting_.insert(before, std::move(waiting));
  goOn();
}

/// Edits of other objects pass.
bool EditHistory::mayGo(std::deque<Waiting>::const_iterator waiting) const {
  const auto first = waiting_.begin();
  if (waiting->isTurn) return waiting == first && inFlight_ == 0 && isMirrored();
  const bool isBlocked = std::any_of(first, waiting, [&](const Waiting& before) {
    return before.isTurn ||
           std::ranges::any_of(before.of, [&](const std::string& name) { return waiting->of.contains(name); });
  });
  if (isBlocked || !waiting->isComposed) return !isBlocked;
  return std::ranges::none_of(waiting->of, [&](const std::string& name) { return edited_.contains(name); });
}

void EditHistory::goOn() {
  if (std::exchange(isGoingOn_, true)) return;
  for (auto at = waiting_.begin(); at != waiting_.end();) {
    if (!mayGo(at)) {
      ++at;
      continue;
    }
    const auto go = std::move(at->go);
    waiting_.erase(at);
    go();
    at = waiting_.begin();
  }
  isGoingOn_ = false;
}

void EditHistory::begin(Edit edit, const std::set<std::string>& of, const std::shared_ptr<Entry>& entry,
                        const EditDone& done) {
  forgetMirrored();
  const auto submittedAt = port_.view();
  if (edit.compose) {
    auto made = edit.compose(*edited());
    if (!made) {
      std::erase(unanswered_, entry);
      if (done) done(tl::unexpected(std::move(made).error()));
      return;
    }
    edit.transaction = *std::move(made);
  }
  auto objects = objectsEditedBy(edit.transaction, *submittedAt->scene);
  edited_.insert(of.begin(), of.end());
  send(std::move(edit),
       [this, submittedAt, objects = std::move(objects), of, entry, done](const Result<v1::Accepted>& outcome) {
         std::erase(unanswered_, entry);
         for (const std::string& name : of) edited_.erase(edited_.find(name));
         if (outcome) {
           entry->changes = take(objects, *submittedAt, *outcome);
           gather(*submittedAt, changedAssets(entry->changes), entry->assets);
           add(entry);
         }
         if (done) done(outcome);
       });
}

/// The newest view, with what edits were answered with and the mirror may lack.
std::shared_ptr<const MirrorView> EditHistory::edited() const {
  const auto view = port_.view();
  if (view->epoch != epoch_ || view->scene->revision() >= revision_) return view;
  std::vector<ObjectRecord> objects;
  auto changed = std::make_shared<MirrorView>(*view);
  const auto isNewer = [&](const Known& known) { return known.revision > view->scene->revision(); };
  for (const auto& object : view->scene->objects()) {
    const auto known = known_.find(object->name);
    if (known == known_.end() || !isNewer(known->second)) objects.push_back(*object);
  }
  for (const auto& [name, known] : known_) {
    if (!isNewer(known) || !known.object) continue;
    objects.push_back(*known.object);
    if (!known.object->movesByItself()) changed->bodies.erase(known.object->id);  // it is where the edit has put it
  }
  auto scene = SceneVersion::fromSnapshot(view->scene->revision(), std::move(objects));
  if (!scene) return view;
  changed->scene = std::make_shared<const SceneVersion>(*std::move(scene));
  return changed;
}

/// Uploads first, one refused upload refuses the edit.
void EditHistory::send(Edit edit, EditDone done) {
  ++inFlight_;
  struct Sending {
    v1::Transaction transaction;
    std::function<void(const v1::EditProgress&)> progress;
    EditDone done;
    std::size_t uploadsLeft;
    std::optional<Error> failure;
  };
  const auto sending = std::make_shared<Sending>(Sending{std::move(edit.transaction), std::move(edit.progress),
                                                         std::move(done), edit.uploads.size(), std::nullopt});
  const auto finish = [this, sending](const Result<v1::Accepted>& outcome) {
    --inFlight_;
    if (outcome) {
      forgetOtherScene();
      epoch_ = port_.view()->epoch;
      revision_ = std::max(revision_, outcome->revision());
    }
    if (sending->done) sending->done(outcome);
    goOn();
  };
  const auto go = [this, sending, finish] {
    if (sending->failure) return finish(tl::unexpected(*sending->failure));
    EditCallbacks callbacks;
    callbacks.replied = [finish](const v1::EditReply& reply) { finish(outcomeOf(reply)); };
    callbacks.progress = std::move(sending->progress);
    port_.submit(std::move(sending->transaction), std::move(callbacks));
  };
  if (edit.uploads.empty()) return go();
  for (AssetContent& content : edit.uploads) {
    UploadCallbacks callbacks;
    callbacks.finished = [sending, go](const v1::AssetUploadReply& reply) {
      if (!reply.accepted() && !sending->failure) {
        const ContentHash name = ContentHash::fromBytes(reply.hash()).value_or(ContentHash{});
        sending->failure = Error{"upload of " + name.hex() + ": " + reply.field(), reply.reason()};
      }
      if (--sending->uploadsLeft == 0) go();
    };
    port_.upload(std::move(content), std::move(callbacks));
  }
}

/// What the transaction did to the objects.
Changes EditHistory::take(const std::vector<EditedObject>& objects, const MirrorView& submittedAt,
                          const v1::Accepted& accepted) {
  Changes changes;
  for (const EditedObject& edited : objects) {
    const auto after = objectAfter(edited, accepted, *port_.view());
    if (!after) continue;
    Known& known = known_[edited.name];
    // Edits that were on their way when this one was submitted come before it.
    const bool isNewer = known.revision > submittedAt.scene->revision();
    const auto change = changeOf(edited, isNewer ? known.object : edited.before, *after);
    known = {accepted.revision(), *after};
    if (isChange(change)) changes.push_back(change);
  }
  return changes;
}

void EditHistory::add(std::shared_ptr<Entry> entry) {
  redo_.clear();
  if (entry->group != 0 && !undo_.empty() && undo_.back()->group == entry->group) {
    Entry& newest = *undo_.back();
    newest.changes = joined(std::move(newest.changes), entry->changes);
    newest.assets.merge(entry->assets);
    const auto needed = changedAssets(newest.changes);
    std::erase_if(newest.assets, [&](const auto& asset) { return !needed.contains(asset.first); });
    newest.text = std::move(entry->text);
    newest.number = ++lastNumber_;
  } else {
    entry->number = ++lastNumber_;
    undo_.push_back(std::move(entry));
  }
  if (undo_.back()->changes.empty()) undo_.pop_back();
  if (undo_.size() > kMaxEntries) {
    oldest_ = undo_.front()->number;
    undo_.pop_front();
  }
}

/// Known objects that the mirror has by now: edits are submitted from its scene.
void EditHistory::forgetMirrored() {
  forgetOtherScene();
  const auto view = port_.view();
  if (inFlight_ > 0) return;
  std::erase_if(known_, [&](const auto& known) { return known.second.revision <= view->scene->revision(); });
}

/// A server that has lost its state begins another scene, in which nothing of before can be undone.
void EditHistory::forgetOtherScene() {
  if (port_.view()->epoch == epoch_) return;
  known_.clear();
  revision_ = 0;
  if (epoch_ == 0) return;
  undo_.clear();
  redo_.clear();
  skipped_.clear();
  oldest_ = ++lastNumber_;
  markSaved(oldest_);
}

EditHistory::Step EditHistory::undone(bool redo) const {
  const Entries& entries = redo ? redo_ : undo_;
  return {entries.empty() ? nullptr : entries.back(), redo};
}

std::optional<EditHistory::Offer> EditHistory::offer(const Step& step) const {
  if (!step.entry) return std::nullopt;
  auto applies = checkSettled();
  if (applies) applies = check(step);
  return Offer{step.entry->text, applies ? std::nullopt : std::optional(std::move(applies).error())};
}

Result<void> EditHistory::check(const Step& step) const {
  if (!step.entry) return refused("", step.redo ? "there is nothing to redo" : "there is nothing to undo");
  const auto view = port_.view();
  if (view->epoch != epoch_) {
    return refused("", std::string("the server has begun another scene since; there is nothing to ") +
                           (step.redo ? "redo" : "undo") + " in it");
  }
  return checkApplies(step.changes(), *view->scene, skipped_);
}

Result<void> EditHistory::checkSettled() const {
  if (inFlight_ > 0 || !waiting_.empty()) {
    return refused("", "an edit is on its way to the server; wait for its answer");
  }
  if (!isMirrored()) return refused("", "the last edit has not come back from the server yet; wait for it");
  return {};
}

bool EditHistory::isMirrored() const {
  const auto view = port_.view();
  return view->epoch != epoch_ || view->scene->revision() >= revision_;
}

void EditHistory::ask(bool redo, EditDone done) {
  if (std::ranges::count(waiting_, true, &Waiting::isTurn) >= std::ptrdiff_t{kMaxEntries}) return;
  std::shared_ptr<Entry> undone;  // null: the newest by then
  if (!redo && !unanswered_.empty()) {
    undone = unanswered_.back();
    std::erase_if(unanswered_, [&](const auto& entry) {
      return entry == undone || (entry->group != 0 && entry->group == undone->group);
    });
  }
  const auto isThere = [this, undone] {
    if (!undone) return true;
    if (undo_.empty()) return false;
    return undo_.back() == undone || (undone->group != 0 && undo_.back()->group == undone->group);
  };
  const auto turned = [this, done = std::move(done)](const Result<v1::Accepted>& outcome) {
    if (!outcome) std::erase_if(waiting_, [](const Waiting& waiting) { return waiting.isTurn; });
    if (done) done(outcome);
  };
  const auto go = [this, redo, isThere, turned] {
    if (isThere()) return turn(redo, turned);
    turned(refused("", "the edit that it was to take back has changed nothing"));
  };
  waiting_.push_back({.go = go, .isTurn = true, .group = undone ? undone->group : 0});
  goOn();
}

void EditHistory::turn(bool redo, EditDone done) {
  const Step step = undone(redo);
  if (auto applies = check(step); !applies) {
    if (done) done(tl::unexpected(std::move(applies).error()));
    return;
  }
  forgetMirrored();
  const auto view = port_.view();
  const SceneVersion& scene = *view->scene;
  const v1::Transaction transaction = transactionFor(step.changes(), scene);
  gather(*view, changedAssets(step.entry->changes), step.entry->assets);
  const auto held = assetsNamedBy(scene);
  std::vector<AssetContent> uploads;
  for (const AssetName& name : assetsNamedBy(transaction)) {
    const auto asset = step.entry->assets.find(name);
    if (!held.contains(name) && asset != step.entry->assets.end()) uploads.push_back(asset->second);
  }
  auto objects = objectsEditedBy(transaction, scene);
  for (const EditedObject& object : objects) edited_.insert(object.name);
  send({transaction, {}, std::move(uploads)},
       [this, step, view, objects = std::move(objects), done = std::move(done)](const Result<v1::Accepted>& outcome) {
         for (const EditedObject& object : objects) edited_.erase(edited_.find(object.name));
         if (outcome) {
           take(objects, *view, *outcome);
           turned(step);
         }
         if (done) done(outcome);
       });
}

/// The entry may have been dropped meanwhile, or an edit may have been accepted, after which nothing is redone.
void EditHistory::turned(const Step& step) {
  Entries& from = step.redo ? redo_ : undo_;
  Entries& to = step.redo ? undo_ : redo_;
  const auto at = std::ranges::find(from, step.entry);
  if (at == from.end()) return;
  const bool isNewest = std::next(at) == from.end();
  from.erase(at);
  step.entry->group = 0;
  if (isNewest) to.push_back(step.entry);
}

void EditHistory::drop(Entries& entries) {
  if (entries.empty()) return;
  for (const ObjectChange& change : entries.back()->changes) skipped_.insert(change.name);
  const bool wasSaved = saved_ == state();
  entries.pop_back();
  // The scene keeps the edit: it is not the one that the entries before would have left.
  if (&entries == &undo_) saved_ = wasSaved ? std::optional(state()) : std::nullopt;
}

void EditHistory::clear() {
  undo_.clear();
  redo_.clear();
  known_.clear();
  skipped_.clear();
  inFlight_ = 0;
  waiting_.clear();
  edited_.clear();
  unanswered_.clear();
  epoch_ = revision_ = 0;
  oldest_ = ++lastNumber_;
  markSaved(oldest_);
}

}  // namespace haptics

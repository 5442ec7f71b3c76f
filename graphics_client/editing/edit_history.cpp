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

/// An object that both change; null: there is none.
const std::string* sharedObject(const Changes& changes, const Changes& others) {
  const auto shared = std::ranges::find_if(changes, [&](const ObjectChange& change) {
    return std::ranges::find(others, change.name, &ObjectChange::name) != others.end();
  });
  return shared == changes.end() ? nullptr : &shared->name;
}

}  // namespace

void EditHistory::submit(Edit edit, EditDone done) {
  auto entry = std::make_shared<Entry>();
  entry->text = edit.text;
  entry->of = edit.of;
  entry->group = edit.group;
  for (const EditedObject& object : objectsEditedBy(edit.transaction, *port_.view()->scene)) {
    entry->of.insert(object.name);
  }
  // Further values of a drag that is to be undone are part of what is undone.
  const auto before = std::ranges::find_if(waiting_, [&](const Waiting& other) {
    return other.turn && !other.turn->redo && other.entry->isOneWith(*entry);
  });
  if (before == waiting_.end()) {
    entry->order = ++lastOrder_;
    unanswered_.push_back(entry);
  } else {
    entry->order = before->entry->order;
  }
  const bool isComposed = edit.compose != nullptr;
  auto go = [this, edit = std::move(edit), entry, done = std::move(done)] { begin(edit, entry, done); };
  waiting_.insert(before, {.go = std::move(go), .entry = std::move(entry), .isComposed = isComposed});
  advance();
}

/// Edits of other objects pass.
bool EditHistory::mayGo(std::deque<Waiting>::const_iterator waiting) const {
  const auto first = waiting_.begin();
  if (waiting->turn) return waiting == first && inFlight_ == 0 && isMirrored();
  const std::set<std::string>& of = waiting->entry->of;
  const bool isBlocked = std::any_of(first, waiting, [&](const Waiting& before) {
    return std::ranges::any_of(before.entry->of, [&](const std::string& name) { return of.contains(name); });
  });
  if (isBlocked || !waiting->isComposed) return !isBlocked;
  return std::ranges::none_of(of, [&](const std::string& name) { return edited_.contains(name); });
}

void EditHistory::advance() {
  if (std::exchange(isAdvancing_, true)) return;
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
  isAdvancing_ = false;
  if (port_.changed) port_.changed();
}

void EditHistory::begin(Edit edit, const std::shared_ptr<Entry>& entry, const EditDone& done) {
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
  edited_.insert(entry->of.begin(), entry->of.end());
  send(std::move(edit),
       [this, submittedAt, objects = std::move(objects), entry, done](const Result<v1::Accepted>& outcome) {
         std::erase(unanswered_, entry);
         for (const std::string& name : entry->of) edited_.erase(edited_.find(name));
         if (outcome && port_.view()->epoch == submittedAt->epoch) {
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
  const auto finish = [this, sending, epoch = port_.view()->epoch](const Result<v1::Accepted>& outcome) {
    --inFlight_;
    if (outcome && port_.view()->epoch == epoch) {
      forgetOtherScene();
      epoch_ = epoch;
      revision_ = std::max(revision_, outcome->revision());
    }
    if (sending->done) sending->done(outcome);
    advance();
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

/// In the order of submission, but after earlier entries of its objects.
EditHistory::Entries::iterator EditHistory::placeOf(const Entry& entry) {
  auto at = undo_.end();
  const auto isBefore = [&](const Entry& other) {
    return other.order > entry.order && sharedObject(entry.changes, other.changes) == nullptr;
  };
  while (at != undo_.begin() && isBefore(**std::prev(at))) --at;
  return at;
}

void EditHistory::add(std::shared_ptr<Entry> entry) {
  const auto isBefore = [&](const std::shared_ptr<const Step>& turn, const std::shared_ptr<Entry>& undone) {
    return turn && turn->redo && turn->entry == undone && turn->order < entry->order;
  };
  std::erase_if(redo_, [&](const std::shared_ptr<Entry>& undone) {
    return !isBefore(turning_, undone) &&
           std::ranges::none_of(waiting_, [&](const Waiting& waiting) { return isBefore(waiting.turn, undone); });
  });
  if (entry->changes.empty()) return;
  auto at = placeOf(*entry);
  if (at != undo_.begin() && (*std::prev(at))->isOneWith(*entry)) {
    Entry& known = **--at;
    known.of.merge(entry->of);
    known.changes = joined(std::move(known.changes), entry->changes);
    known.assets.merge(entry->assets);
    const auto needed = changedAssets(known.changes);
    std::erase_if(known.assets, [&](const auto& asset) { return !needed.contains(asset.first); });
    known.text = std::move(entry->text);
  } else {
    at = undo_.insert(at, std::move(entry));
  }
  if ((*at)->changes.empty()) at = undo_.erase(at);
  renumber(at, undo_.end());
  if (undo_.size() > kMaxEntries) {
    oldest_ = undo_.front()->number;
    undo_.pop_front();
  }
}

/// Each of them leaves another scene than before.
void EditHistory::renumber(Entries::iterator from, Entries::iterator end) {
  for (; from != end; ++from) (*from)->number = ++lastNumber_;
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

/// Of the entry that this one has become, or a part of.
EditHistory::Step EditHistory::undoneOf(const Entry& entry) const {
  const auto at =
      std::find_if(undo_.rbegin(), undo_.rend(), [&](const auto& other) { return other->isOneWith(entry); });
  return {at == undo_.rend() ? nullptr : *at, false};
}

std::optional<EditHistory::Offer> EditHistory::offer(const Step& step) const {
  if (!step.entry) return std::nullopt;
  auto applies = checkSettled();
  if (applies) applies = check(step);
  return Offer{step.entry->text, applies ? std::nullopt : std::optional(std::move(applies).error())};
}

Result<void> EditHistory::check(const Step& step) const {
  const std::string nothing = std::string("there is nothing to ") + (step.redo ? "redo" : "undo");
  if (isOtherScene()) return refused("", "the server has begun another scene since; " + nothing + " in it");
  if (!step.entry) return refused("", nothing);
  // An edit that takes the server long is accepted after others of its object.
  for (auto later = undo_.rbegin(); !step.redo && later != undo_.rend() && *later != step.entry; ++later) {
    if (const auto* name = sharedObject(step.entry->changes, (*later)->changes)) {
      return refused("object \"" + *name + "\"",
                     "was changed since by \"" + (*later)->text + "\", which was asked for before; undo that first");
    }
  }
  return checkApplies(step.changes(), *port_.view()->scene, skipped_);
}

Result<void> EditHistory::checkSettled() const {
  if (inFlight_ > 0 || !waiting_.empty()) {
    return refused("", "an edit is on its way to the server; wait for its answer");
  }
  if (!isMirrored()) return refused("", "the last edit has not come back from the server yet; wait for it");
  return {};
}

bool EditHistory::isOtherScene() const { return epoch_ != 0 && port_.view()->epoch != epoch_; }

bool EditHistory::isMirrored() const {
  const auto view = port_.view();
  return view->epoch != epoch_ || view->scene->revision() >= revision_;
}

/// The newest entry once all is done that was asked for; null: there is none.
std::shared_ptr<EditHistory::Entry> EditHistory::undoneByThen(bool redo) const {
  using Ordered = std::pair<std::uint64_t, std::shared_ptr<Entry>>;
  std::vector<Ordered> undo;
  const auto add = [&](std::uint64_t order, const std::shared_ptr<Entry>& entry) {
    const auto later =
        std::find_if(undo.rbegin(), undo.rend(), [&](const Ordered& other) { return other.first <= order; });
    undo.insert(later.base(), {order, entry});
  };
  for (const auto& entry : undo_) undo.emplace_back(entry->order, entry);
  for (const auto& entry : unanswered_) add(entry->order, entry);
  Entries again = redo_;
  const auto follow = [&](const Step& turn) {
    if (turn.redo) {
      if (!again.empty()) again.pop_back();
      add(turn.order, turn.entry);
    } else {
      std::erase_if(undo, [&](const Ordered& other) { return other.second->isOneWith(*turn.entry); });
      again.push_back(turn.entry);
    }
  };
  if (turning_) follow(*turning_);
  for (const Waiting& waiting : waiting_) {
    if (waiting.turn) follow(*waiting.turn);
  }
  if (redo) return again.empty() ? nullptr : again.back();
  return undo.empty() ? nullptr : undo.back().second;
}

void EditHistory::ask(bool redo, EditDone done) {
  const auto isTurn = [](const Waiting& waiting) { return waiting.turn != nullptr; };
  if (std::ranges::count_if(waiting_, isTurn) >= std::ptrdiff_t{kMaxEntries}) return;
  const auto entry = undoneByThen(redo);
  if (!entry) {
    if (done) done(tl::unexpected(check({nullptr, redo}).error()));
    return;
  }
  if (!redo) std::erase_if(unanswered_, [&](const auto& other) { return other->isOneWith(*entry); });
  const auto turned = [this, isTurn, done = std::move(done)](const Result<v1::Accepted>& outcome) {
    turning_.reset();
    if (!outcome) std::erase_if(waiting_, isTurn);
    if (done) done(outcome);
  };
  const auto asked = std::make_shared<Step>(Step{entry, redo, ++lastOrder_});
  const auto go = [this, asked, turned] {
    const auto present = asked->redo ? undone(true).entry : undoneOf(*asked->entry).entry;
    if (!asked->redo && !present && !isOtherScene()) {
      return turned(refused("", "the edit that it was to take back has changed nothing"));
    }
    asked->entry = present;
    turning_ = asked;
    turn(*asked, turned);
  };
  waiting_.push_back({.go = go, .entry = entry, .turn = asked});
  advance();
}

void EditHistory::turn(const Step& step, EditDone done) {
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
         if (outcome && port_.view()->epoch == view->epoch) {
           take(objects, *view, *outcome);
           turned(step);
         }
         if (done) done(outcome);
       });
}

/// The entry may have been dropped meanwhile, or an edit may have been accepted, after which nothing is redone but what was
/// asked for before it.
void EditHistory::turned(const Step& step) {
  Entries& from = step.redo ? redo_ : undo_;
  const auto at = std::ranges::find(from, step.entry);
  if (at == from.end()) return;
  const auto later = from.erase(at);
  bool staysToRedo = later == from.end();
  for (Waiting& waiting : waiting_) {
    if (!waiting.turn || !waiting.entry->isOneWith(*step.entry)) continue;
    waiting.entry = waiting.turn->entry = step.entry;  // which its edit may have become a part of
    staysToRedo |= waiting.turn->redo;
  }
  step.entry->group = 0;
  if (!step.redo) {
    if (staysToRedo) redo_.push_back(step.entry);
    return renumber(later, undo_.end());
  }
  step.entry->order = step.order;
  const auto place = undo_.insert(placeOf(*step.entry), step.entry);
  if (std::next(place) != undo_.end()) renumber(place, undo_.end());
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
  turning_.reset();
  edited_.clear();
  unanswered_.clear();
  epoch_ = revision_ = 0;
  oldest_ = ++lastNumber_;
  markSaved(oldest_);
  if (port_.changed) port_.changed();
}

}  // namespace haptics

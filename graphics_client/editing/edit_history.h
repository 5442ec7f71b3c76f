#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/assets/asset_content.h"
#include "common/error/error.h"
#include "graphics_client/editing/named_assets.h"
#include "graphics_client/editing/object_change.h"
#include "graphics_client/mirror/client_callbacks.h"
#include "graphics_client/mirror/edit_reply.h"
#include "graphics_client/mirror/mirror_view.h"

namespace haptics {

/// What edits need of the application: a ServerLink, whose callbacks it hands to the thread that edits.
struct EditPort {
  std::function<std::shared_ptr<const MirrorView>()> view;  ///< The newest; never null.
  std::function<void(v1::Transaction, EditCallbacks)> submit;
  /// Sends the content's canonical bytes, which may take long to make: not on this thread.
  std::function<void(AssetContent, UploadCallbacks)> upload;
  std::function<void()> changed = nullptr;  ///< What can be undone and redone may be another now.
};

/// Makes an edit of what the scene is. Refused: it cannot be made of that.
using Composer = std::function<Result<v1::Transaction>(const MirrorView&)>;

struct Edit {
  v1::Transaction transaction = {};
  std::string text = {};  ///< For a menu: "Move cup".
  /// Named by the transaction and perhaps not held by the server: they are sent before it.
  std::vector<AssetContent> uploads = {};
  std::uint64_t group = 0;  ///< Not 0: one entry of the history together with the newest, if that is of the same group.
  /// Of an edit that takes the server long.
  std::function<void(const v1::EditProgress&)> progress = nullptr;
  /// Makes the transaction, which is empty, once all earlier edits of the objects `of` are answered, from the view as they
  /// have left it: the mirror may hear of them later, and what it has until then would take them back.
  Composer compose = nullptr;
  std::set<std::string> of = {};
};

/// Submits this user's edits and undoes them. An entry holds, for each object that its edit changed, the record before
/// and after. It is undone by one transaction, provided that the objects still have the content that the edit left:
/// what others did since is not overwritten. Edits, undo and redo count in the order in which they were asked for; what has
/// to wait for an answer waits here. One thread, on which the port's callbacks come too; none of them comes
/// after this is gone.
class EditHistory {
 public:
  static constexpr std::size_t kMaxEntries = 1000;  ///< Beyond, the oldest is dropped.

  explicit EditHistory(EditPort port) : port_(std::move(port)) {}
  EditHistory(const EditHistory&) = delete;
  EditHistory& operator=(const EditHistory&) = delete;

  /// Uploads, then submits. Accepted, it becomes an entry, and nothing is left to redo. The newest entry is the one that was
  /// submitted last.
  void submit(Edit edit, EditDone done = {});
  [[nodiscard]] std::uint64_t newGroup() noexcept { return ++lastGroup_; }

  struct Offer {
    std::string text;  ///< Of the edit.
    std::optional<Error>
        refusal;  ///< Why it cannot be undone or redone now; names the object that somebody else changed.
  };
  /// Of the newest entry, by the port's view. Nothing: there is no entry.
  [[nodiscard]] std::optional<Offer> undoOffer() const { return offer(undone(false)); }
  [[nodiscard]] std::optional<Offer> redoOffer() const { return offer(undone(true)); }
  /// The last edit is answered, and the view has it: until then nothing is undone or redone.
  [[nodiscard]] bool isSettled() const { return checkSettled().has_value(); }
  /// As soon as the history is settled: takes back the edit that was submitted last before this, if that was accepted. Until
  /// then edits of other objects pass. The entry changes sides when the server accepts; in conflict or rejected it stays, and
  /// what was asked of undo and redo behind it is dropped. `done` gets the reason, also when the offer is a refusal, or there is
  /// nothing to undo, which is said at once.
  void undo(EditDone done = {}) { ask(false, std::move(done)); }
  void redo(EditDone done = {}) { ask(true, std::move(done)); }
  /// Does what waits and need not any more. To be called now and then, as the mirror follows.
  void advance();
  /// Skips the newest entry, so that those before it can be undone or redone, unless they are of the same objects.
  void dropUndo() { drop(undo_); }
  void dropRedo() { drop(redo_); }

  /// The scene as this user's accepted edits have left it, by a number: another one after each.
  [[nodiscard]] std::uint64_t state() const { return undo_.empty() ? oldest_ : undo_.back()->number; }
  /// The scene of this state is in a file.
  void markSaved(std::uint64_t state) { saved_ = state; }
  /// Nothing is lost when the scene is: there is no edit since markSaved(), none under way, or they were undone.
  [[nodiscard]] bool isSaved() const { return inFlight_ == 0 && waiting_.empty() && saved_ == state(); }
  /// The scene is another server's: there is nothing to undo in it. Outcomes of before must not come any more.
  void clear();

 private:
  struct Entry {
    std::string text;
    std::set<std::string> of;  // objects that the edit names
    std::uint64_t group = 0;
    std::uint64_t order = 0;   // of its submission
    std::uint64_t number = 0;  // another one whenever its changes are, or those of an entry before it
    Changes changes;
    NamedAssets assets;  // named on one side of the changes only: the server may not hold them any more
    [[nodiscard]] bool isOneWith(const Entry& other) const {
      return this == &other || (group != 0 && group == other.group);
    }
  };
  using Entries = std::deque<std::shared_ptr<Entry>>;  // the newest last
  struct Known {
    std::uint64_t revision = 0;
    SceneVersion::Object object;  // null: it is not there
  };
  struct Step {
    std::shared_ptr<Entry> entry;
    bool redo = false;
    std::uint64_t order = 0;  // in which it was asked for, among the edits
    [[nodiscard]] Changes changes() const { return redo ? entry->changes : reversed(entry->changes); }
  };
  /// An edit, or a turn: an undo or redo.
  struct Waiting {
    std::function<void()> go;
    std::shared_ptr<Entry> entry;  // of the edit; the one that is to be undone or redone, or becomes a part of it
    bool isComposed = false;
    std::shared_ptr<Step> turn = nullptr;
  };

  EditPort port_;
  Entries undo_;  // in the order of submission; of one object, in that in which they were accepted
  Entries redo_;
  std::uint64_t lastGroup_ = 0, lastOrder_ = 0, lastNumber_ = 0;
  std::uint64_t oldest_ = 0;  // number of the entry before the oldest that can be undone
  std::optional<std::uint64_t> saved_ = 0;
  std::set<std::string> skipped_;  // objects of dropped entries
  std::size_t inFlight_ = 0;
  std::deque<Waiting> waiting_;
  std::shared_ptr<const Step> turning_;  // in flight
  bool isAdvancing_ = false;
  std::multiset<std::string> edited_;               // objects of edits that are in flight
  std::vector<std::shared_ptr<Entry>> unanswered_;  // and no undo was asked for; the newest last
  // Of the newest accepted transaction. The mirror may hear of it after the reply.
  std::uint64_t epoch_ = 0, revision_ = 0;
  std::map<std::string, Known> known_;  // by accepted transactions that the mirror may lack, by name

  [[nodiscard]] bool mayGo(std::deque<Waiting>::const_iterator waiting) const;
  void begin(Edit edit, const std::shared_ptr<Entry>& entry, const EditDone& done);
  void send(Edit edit, EditDone done);
  void ask(bool redo, EditDone done);
  void turn(const Step& step, EditDone done);
  void turned(const Step& step);
  [[nodiscard]] std::shared_ptr<Entry> undoneByThen(bool redo) const;
  [[nodiscard]] Entries::iterator placeOf(const Entry& entry);
  [[nodiscard]] Step undone(bool redo) const;
  [[nodiscard]] Step undoneOf(const Entry& entry) const;
  [[nodiscard]] std::optional<Offer> offer(const Step& step) const;
  [[nodiscard]] Result<void> check(const Step& step) const;
  [[nodiscard]] Result<void> checkSettled() const;
  [[nodiscard]] bool isMirrored() const;
  [[nodiscard]] bool isOtherScene() const;
  void forgetMirrored();
  void forgetOtherScene();
  [[nodiscard]] std::shared_ptr<const MirrorView> edited() const;
  Changes take(const std::vector<EditedObject>& objects, const MirrorView& submittedAt, const v1::Accepted& accepted);
  void add(std::shared_ptr<Entry> entry);
  void renumber(Entries::iterator from, Entries::iterator end);
  void drop(Entries& entries);
};

}  // namespace haptics

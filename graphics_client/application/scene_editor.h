#pragma once

#include <QObject>
#include <QString>
#include <QThreadPool>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "graphics_client/editing/edit_history.h"
#include "graphics_client/editing/latest_edit.h"
#include "graphics_client/mirror/server_link.h"

namespace haptics {

/// The edits of the window's user. All on the window's thread.
class SceneEditor {
 public:
  /// Tells what came of an edit: its name, and what the server said.
  using Say = std::function<void(const QString& edit, const QString& words, bool isError)>;
  using Accepted = std::function<void(const v1::Accepted&)>;

  /// @param window   On whose thread callbacks come; none comes after it is gone.
  /// @param changed  What can be undone and redone may be another now.
  SceneEditor(QObject* window, ServerLink& link, Say say, Accepted accepted, std::function<void()> changed);

  /// A value of a property that is being dragged; the values until finishDrag() are one edit.
  /// @param value  Its text is `edit`.
  void drag(const QString& edit, const Edit& value);
  void finishDrag() { drag_.reset(); }
  void submit(const QString& edit, Edit made);
  /// A generated object, 50 mm large.
  /// @param kind  "sphere", "box", "cylinder" or "torus".
  /// @param foot  Where the middle of its lower side goes, world frame.
  /// @return Its name.
  std::string add(const std::string& kind, Vec3 foot);
  /// Of what add() adds.
  static constexpr double kSize_m = 0.05;
  /// An object of a mesh that the server was sent. `done` is told its name, and the outcome.
  void addMesh(const std::string& wantedName, const ContentHash& mesh, Vec3 position_m,
               std::function<void(const v1::EditProgress&)> progress,
               std::function<void(const std::string& name, const Result<v1::Accepted>&)> done);
  /// All of them by one edit.
  void duplicate(const std::set<std::string>& objects);
  void remove(const std::set<std::string>& objects);
  /// Its motion begins anew where the scene has it.
  /// @param done  It has the name.
  void rename(const std::string& object, const std::string& wanted, const std::function<void()>& done);
  /// What a scene file holds, in place of the present objects.
  /// @param done  Once the server has accepted it.
  void open(Edit edit, const std::function<void()>& done);

  [[nodiscard]] std::shared_ptr<const MirrorView> view() const { return link_.latest(); }
  /// As EditHistory's.
  [[nodiscard]] std::uint64_t state() const { return history_.state(); }
  void markSaved(std::uint64_t state) { history_.markSaved(state); }
  [[nodiscard]] bool isSaved() const { return history_.isSaved(); }
  /// The link is to another server: nothing can be undone, and no outcome of before comes any more.
  void startAnew();
  /// Every edit is refused with these words. Empty: edits go to the server.
  void refuseAll(std::string why) { refusal_ = std::move(why); }
  [[nodiscard]] const std::string& refusal() const { return refusal_; }
  /// Waits until nothing uses the link any more.
  void finish() { encoding_.waitForDone(); }

  /// As EditHistory's.
  void undo() { history_.undo(said("undo")); }
  void redo() { history_.redo(said("redo")); }
  /// To be called again and again: does what can be done by now.
  void advance();
  /// Something is under way that undo may take back.
  [[nodiscard]] bool isBusy() const { return !history_.isSettled(); }
  [[nodiscard]] std::optional<EditHistory::Offer> undoOffer() const { return history_.undoOffer(); }
  [[nodiscard]] std::optional<EditHistory::Offer> redoOffer() const { return history_.redoOffer(); }

 private:
  QObject* window_;
  ServerLink& link_;
  Say say_;
  Accepted accepted_;
  EditHistory history_;
  std::optional<LatestEdit> drag_;
  QString dragged_;
  std::string refusal_;
  std::shared_ptr<int> server_ = std::make_shared<int>();  // its lifetime is that of the present server's callbacks
  QThreadPool encoding_;
  std::set<std::string> given_;  // names of objects that are on their way to the server

  /// "cup", or "cup-2", "cup-3" ... where there is one.
  [[nodiscard]] std::string freeName(const SceneVersion& scene, const std::string& wanted);
  [[nodiscard]] EditPort port(std::function<void()> changed);
  [[nodiscard]] EditDone said(const QString& edit);
  void submit(const QString& edit, v1::Operation operation);
};

}  // namespace haptics

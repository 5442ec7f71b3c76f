#pragma once

#include <QObject>
#include <QString>
#include <QThreadPool>
#include <functional>
#include <memory>

#include "graphics_client/application/scene_editor.h"

class QWidget;

namespace haptics {

/// Opens and saves scene files, and asks before edits are lost that are in none. Files are read and written on a thread
/// of its own; every dialog is answered later.
class SceneFiles : public QObject {
  Q_OBJECT

 public:
  SceneFiles(QWidget* window, SceneEditor& editor);

  /// Asks for the file.
  void open();
  /// In place of the present objects, once edits that are in no file are dealt with.
  void open(const QString& file);
  /// To the file that was opened or saved last; asks for one where there is none.
  /// @param then  Once the file is written.
  void save(const std::function<void()>& then = {});
  void saveAs(const std::function<void()>& then = {});
  /// Goes on at once where this user has made no edit since the last save, else asks whether to save, to discard or not
  /// to go on.
  /// @param what  "Quitting".
  void askBeforeLoss(const QString& what, const std::function<void()>& then);
  /// The scene is another server's.
  void forget() {
    file_.clear();
    shown_.reset();
    ++server_;
  }
  /// To be called again and again. Of a server that was started anew, with another scene than what was shown, restarted() comes; then
  /// it asks whether to save what was shown, where edits of this user are lost with it.
  void follow();

 signals:
  void restarted();
  void said(const QString& what, const QString& words, bool isError);

 private:
  QWidget* window_;
  SceneEditor& editor_;
  int server_ = 0;  // counts those that were shown
  QString file_;
  std::shared_ptr<const MirrorView> shown_;  // last, of this server
  QThreadPool files_;

  [[nodiscard]] bool isRefused();
  void askForFile(const std::function<void(const QString& file)>& chosen);
  /// @param server  Of which the view is.
  void write(const QString& file, const std::shared_ptr<const MirrorView>& view, int server,
             const std::function<void()>& then);
  void fail(const QString& what, const Error& error);
};

}  // namespace haptics

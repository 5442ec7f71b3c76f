#pragma once

#include <QString>
#include <QThreadPool>
#include <QWidget>
#include <deque>
#include <functional>
#include <memory>
#include <stop_token>

#include "graphics_client/application/scene_editor.h"
#include "graphics_client/editing/local_asset.h"

class QLabel;
class QProgressBar;
class QPushButton;

namespace haptics {

/// Adds mesh files to the scene, one after the other: each is read and converted by a process of its own, sent, and added
/// as an object. Shows how far that is, with a button that ends it; hidden while there is nothing to do.
class MeshImporter : public QWidget {
  Q_OBJECT

 public:
  MeshImporter(ServerLink& link, SceneEditor& editor);
  ~MeshImporter() override { finish(); }

  /// @param foot  Where the middle of the mesh's lower side goes, world frame, once its size is known.
  void import(const QString& file, std::function<Vec3(Vec3 size_m)> foot);
  /// Ends it and those that wait; nothing is changed. Not what the server has begun to add, which undo takes back.
  void cancel();
  [[nodiscard]] bool canCancel() const;
  void startAnew();  ///< The link is to another server: what is under way ends without a word.
  /// Waits until nothing uses the link any more.
  void finish();

 signals:
  /// @param report  What was kept of the file, and the server's remarks.
  void imported(const QString& object, const QString& report);
  /// Nothing was changed.
  /// @param file  Its name, without the folder.
  void failed(const QString& file, const QString& why);

 private:
  struct Import {
    QString file;
    std::function<Vec3(Vec3 size_m)> foot;
    std::stop_source stop = {};
    MeshReport report = {};
    ContentHash mesh = {};  // once it is read
  };

  ServerLink& link_;
  SceneEditor& editor_;
  QLabel* what_;
  QProgressBar* bar_;
  QPushButton* cancel_;
  QThreadPool pool_;
  std::deque<std::shared_ptr<Import>> imports_;  // the first is under way

  [[nodiscard]] bool isUnderWay(const std::shared_ptr<Import>& import) const;
  void begin();
  void upload(Result<LocalMesh> mesh);
  void add();
  void show(const QString& stage, std::optional<double> share);
  void fail(const std::string& why);
  void next();
};

}  // namespace haptics

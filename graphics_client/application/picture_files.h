#pragma once

#include <QTimer>
#include <QWidget>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "graphics_client/application/recording_video.h"
#include "graphics_client/application/view_widget.h"

class QLabel;
class QMenu;
class QProgressBar;

namespace haptics {

/// What leaves the window as files: pictures, a video of the recording that is shown, and a film of the window as it is
/// used. Shows how far a video is, with a button that ends it; hidden while there is none.
class PictureFiles : public QWidget {
  Q_OBJECT

 public:
  /// @param session  The recording that is shown; null: none.
  PictureFiles(ViewWidget* view, SceneView& scene, std::function<std::shared_ptr<const RecordedSession>()> session);

  /// As MainWindow::addAction().
  using AddAction = std::function<QAction*(QMenu*, const QString& title, const QKeySequence& key, const QString& tip,
                                           std::function<void()> does)>;
  void addActions(QMenu* menu, const AddAction& add);
  /// To be called when the window may look other than before.
  void film(double now_s);
  /// Ends what is under way; a film is kept, a part of a video is not.
  void finish();

 signals:
  void said(const QString& what, const QString& words, bool isError);

 private:
  struct Film {
    QString file;
    QSize size_px;
    WebmWriter writer;
    double begun_s, last_s;
  };

  ViewWidget* view_;
  SceneView& scene_;
  std::function<std::shared_ptr<const RecordedSession>()> session_;
  int pictures_ = 0, films_ = 0;
  double now_s_ = 0;
  QAction* filming_ = nullptr;
  std::optional<Film> film_;
  QString videoFile_;
  std::unique_ptr<RecordingVideo> video_;
  QTimer drawing_;
  QLabel* what_;
  QProgressBar* progress_;

  void savePicture();
  void savePictureAs();
  void askForVideo();
  void begin(const QString& file, QSize size_px, int rate_Hz);
  void drawNext();
  void endVideo(const QString& words, bool isError);
  void cancel();
  void setFilming(bool on);
  [[nodiscard]] QImage windowPicture() const;
};

}  // namespace haptics

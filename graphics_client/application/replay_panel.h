#pragma once

#include <QWidget>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "graphics_client/application/plot_panel.h"
#include "graphics_client/session/recorded_session.h"
#include "graphics_client/session/replay_clock.h"

class QComboBox;
class QLabel;
class QMenu;
class QProgressBar;
class QPushButton;

namespace haptics {

class TimeSlider;

/// A recording with its time line, in place of what a server sends. The step runs over it once, on a thread of the
/// panel's; then its moments are in memory. Hidden while there is none.
class ReplayPanel : public QWidget {
  Q_OBJECT

 public:
  ReplayPanel();

  /// As MainWindow::addAction().
  using AddAction = std::function<QAction*(QMenu*, const QString& title, const QKeySequence& key, const QString& tip,
                                           std::function<void()> does)>;
  /// What can be done with a recording; enabled while one is shown.
  void addActions(QMenu* menu, const AddAction& add);
  /// Asks for a file.
  void open();
  void open(const QString& file);
  void cancel();
  /// Shows the server again.
  void leave();

  [[nodiscard]] bool isShown() const { return session_ != nullptr; }
  /// Null: none is shown.
  [[nodiscard]] const std::shared_ptr<const RecordedSession>& session() const { return session_; }
  /// A recording is being read.
  [[nodiscard]] bool isLoading() const { return isLoading_; }
  /// The moment to draw, dt_s after the last call. Only while a recording is shown.
  [[nodiscard]] std::shared_ptr<const MirrorView> next(double dt_s);
  /// "replay of FILE, 3.20 s of 10.00 s; ...".
  [[nodiscard]] QString status() const;
  /// The moments up to the one that is shown, as far back as curves go.
  [[nodiscard]] std::vector<PlotPanel::Sample> curves() const;

 signals:
  /// A recording is shown from now on, or none any more.
  void changed();
  void said(const QString& what, const QString& words, bool isError);

 private:
  std::shared_ptr<const RecordedSession> session_;
  ReplayClock clock_;
  QWidget *loading_, *playing_;
  QLabel* loadingText_;
  QProgressBar* progress_;
  QPushButton* play_;
  TimeSlider* slider_;
  QComboBox* speed_;
  QLabel* time_;
  std::vector<QAction*> actions_;
  QAction* pause_ = nullptr;
  bool isLoading_ = false;
  std::jthread reading_;

  [[nodiscard]] QWidget* makeLoading();
  [[nodiscard]] QWidget* makePlaying();
  void take(const QString& file, Result<RecordedSession> session);
  void togglePlaying();
  void step(int moments);
  void setSpeed(int index);
  void refresh();
};

}  // namespace haptics

#include "graphics_client/application/replay_panel.h"

#include <QAction>
#include <QComboBox>
#include <QFileDialog>
#include <QFileInfo>
#include <QHBoxLayout>
#include <QLabel>
#include <QProgressBar>
#include <QPushButton>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/log/log.h"
#include "common/text/printable.h"
#include "graphics_client/application/plotted_sample.h"
#include "graphics_client/application/time_slider.h"

namespace haptics {
namespace {

constexpr int kPercent = 100;
const QString kWhat = "Open recording";

QPushButton* button(const QString& words, const QString& tip) {
  auto* made = new QPushButton(words);
  made->setToolTip(tip);
  made->setFocusPolicy(Qt::TabFocus);
  return made;
}

}  // namespace

ReplayPanel::ReplayPanel() : loading_(makeLoading()), playing_(makePlaying()) {
  setObjectName("replay");
  auto* rows = new QVBoxLayout(this);
  rows->setContentsMargins(6, 2, 6, 2);
  rows->addWidget(loading_);
  rows->addWidget(playing_);
  loading_->hide();
  playing_->hide();
  hide();
}

QWidget* ReplayPanel::makeLoading() {
  auto* panel = new QWidget;
  auto* row = new QHBoxLayout(panel);
  row->setContentsMargins(0, 0, 0, 0);
  loadingText_ = new QLabel;
  progress_ = new QProgressBar;
  progress_->setRange(0, kPercent);
  auto* cancelling = button("Cancel", "Leaves the recording; the server is shown on");
  connect(cancelling, &QPushButton::clicked, [this] { cancel(); });
  row->addWidget(loadingText_);
  row->addWidget(progress_, 1);
  row->addWidget(cancelling);
  return panel;
}

QWidget* ReplayPanel::makePlaying() {
  auto* panel = new QWidget;
  auto* row = new QHBoxLayout(panel);
  row->setContentsMargins(0, 0, 0, 0);
  play_ = button("Play", "Plays the recording, or stops it (Space)");
  play_->setObjectName("play");
  connect(play_, &QPushButton::clicked, [this] { togglePlaying(); });
  slider_ = new TimeSlider;
  slider_->setAccessibleName("time");
  connect(slider_, &TimeSlider::sought, [this](double time_s) {
    clock_.seek(time_s);
    refresh();
  });
  time_ = new QLabel;
  time_->setObjectName("replay time");
  time_->setMinimumWidth(time_->fontMetrics().horizontalAdvance("0000.000 s of 0000.000 s"));
  time_->setAlignment(Qt::AlignRight | Qt::AlignVCenter);
  speed_ = new QComboBox;
  speed_->setObjectName("speed");
  speed_->setToolTip("How fast it plays, against the time in which it was recorded");
  speed_->setFocusPolicy(Qt::TabFocus);
  for (const double speed : ReplayClock::kSpeeds) speed_->addItem(QString("%1x").arg(speed));
  speed_->setCurrentIndex(static_cast<int>(clock_.speed()));
  connect(speed_, QOverload<int>::of(&QComboBox::currentIndexChanged), [this](int index) { setSpeed(index); });
  auto* leaving = button("Back to the server", "Ends the replay (Ctrl+B)");
  connect(leaving, &QPushButton::clicked, [this] { leave(); });
  for (QWidget* each : {static_cast<QWidget*>(play_), static_cast<QWidget*>(slider_), static_cast<QWidget*>(time_),
                        static_cast<QWidget*>(speed_), static_cast<QWidget*>(leaving)}) {
    row->addWidget(each, each == slider_ ? 1 : 0);
  }
  return panel;
}

void ReplayPanel::addActions(QMenu* menu, const AddAction& add) {
  pause_ = add(menu, "&Play or stop", Qt::Key_Space, "Plays the recording, or stops it", [this] { togglePlaying(); });
  actions_ = {pause_,
              add(menu, "One sample &back", Qt::Key_Comma, "The sample before", [this] { step(-1); }),
              add(menu, "One sample &forward", Qt::Key_Period, "The next sample", [this] { step(1); }),
              add(menu, "&Slower", Qt::Key_BracketLeft, "1x, 0.5x, 0.1x of the recorded speed",
                  [this] { setSpeed(speed_->currentIndex() - 1); }),
              add(menu, "F&aster", Qt::Key_BracketRight, "0.1x, 0.5x, 1x of the recorded speed",
                  [this] { setSpeed(speed_->currentIndex() + 1); }),
              add(menu, "Back to the ser&ver", QKeySequence("Ctrl+B"), "Ends the replay", [this] { leave(); })};
  for (QAction* action : actions_) action->setEnabled(false);
}

void ReplayPanel::open() {
  auto* dialog = new QFileDialog(this, kWhat, {}, "Recordings (*.haptics);;All files (*)");
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setFileMode(QFileDialog::ExistingFile);
  connect(dialog, &QFileDialog::fileSelected, this, [this](const QString& file) { open(file); });
  dialog->open();
}

void ReplayPanel::open(const QString& file) {
  if (isLoading_) return emit said(kWhat, "another recording is being opened; cancel that first", true);
  isLoading_ = true;
  loadingText_->setText("Replaying " + QFileInfo(file).fileName());
  progress_->setValue(0);
  loading_->show();
  show();
  reading_ = std::jthread([this, file](const std::stop_token& stop) {
    int shown = 0;
    auto session =
        std::make_shared<Result<RecordedSession>>(RecordedSession::read(file.toStdString(), stop, [&](double share) {
          const int percent = static_cast<int>(kPercent * share);
          if (percent <= shown) return;
          shown = percent;
          QMetaObject::invokeMethod(this, [this, percent] { progress_->setValue(percent); });
        }));
    QMetaObject::invokeMethod(this, [this, file, session] { take(file, std::move(*session)); });
  });
}

void ReplayPanel::cancel() { reading_.request_stop(); }

void ReplayPanel::take(const QString& file, Result<RecordedSession> session) {
  isLoading_ = false;
  loading_->hide();
  setVisible(isShown());
  if (!session) return emit said(kWhat, QString::fromStdString(printable(session.error().text())), true);
  session_ = std::make_shared<const RecordedSession>(*std::move(session));
  const std::size_t speed = clock_.speed();
  clock_ = ReplayClock(session_->duration_s());
  clock_.setSpeed(speed);
  slider_->show(session_->duration_s(), session_->marks());
  playing_->show();
  show();
  for (QAction* action : actions_) action->setEnabled(true);
  clock_.setPlaying(true);
  refresh();
  logInfo(session_->status(0) + " (" + file.toStdString() + "); " + session_->extent());
  emit said(kWhat, QString::fromStdString(session_->extent()), false);
  emit changed();
}

void ReplayPanel::leave() {
  if (!isShown()) return;
  session_ = nullptr;
  playing_->hide();
  setVisible(isLoading_);
  for (QAction* action : actions_) action->setEnabled(false);
  logInfo("back to the server");
  emit changed();
}

void ReplayPanel::togglePlaying() {
  clock_.setPlaying(!clock_.isPlaying());
  refresh();
}

void ReplayPanel::step(int moments) {
  clock_.setPlaying(false);
  const auto& list = session_->moments().list();
  const auto now = static_cast<std::ptrdiff_t>(session_->moments().indexAt(clock_.time_s()));
  const auto to = std::clamp<std::ptrdiff_t>(now + moments, 0, static_cast<std::ptrdiff_t>(list.size()) - 1);
  clock_.seek(list[static_cast<std::size_t>(to)].time_s);
  refresh();
}

void ReplayPanel::setSpeed(int index) {
  clock_.setSpeed(static_cast<std::size_t>(std::max(0, index)));
  speed_->setCurrentIndex(static_cast<int>(clock_.speed()));
}

std::shared_ptr<const MirrorView> ReplayPanel::next(double dt_s) {
  if (clock_.isPlaying()) {
    clock_.advance(dt_s);
    refresh();
  }
  return session_->view(session_->moments().indexAt(clock_.time_s()), monotonicNow_ns());
}

void ReplayPanel::refresh() {
  play_->setText(clock_.isPlaying() ? "Stop" : "Play");
  slider_->setTime(clock_.time_s());
  time_->setText(QString("%1 s of %2 s").arg(clock_.time_s(), 0, 'f', 3).arg(clock_.duration_s(), 0, 'f', 3));
}

QString ReplayPanel::status() const { return QString::fromStdString(session_->status(clock_.time_s())); }

std::vector<PlotPanel::Sample> ReplayPanel::curves() const {
  return plottedUntil(session_->moments(), clock_.time_s());
}

}  // namespace haptics

#include "moc_replay_panel.cpp"

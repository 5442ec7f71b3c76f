#include "graphics_client/application/picture_files.h"

#include <QAction>
#include <QDir>
#include <QFile>
#include <QHBoxLayout>
#include <QLabel>
#include <QPainter>
#include <QProgressBar>
#include <QPushButton>
#include <algorithm>
#include <utility>

#include "graphics_client/application/picture_dialog.h"
#include "graphics_client/application/printable_text.h"

namespace haptics {
namespace {

constexpr int kProgress_px = 160;
/// Of a film, at most: what one core draws and encodes beside the window's own pictures.
constexpr double kFilm_Hz = 20;
constexpr int kVideo_Hz = 25;
constexpr QSize kVideo_px(1280, 800);
const QString kPicture = "picture", kVideo = "video", kFilm = "film";

QString isWritten(const QString& file) { return QDir::current().absoluteFilePath(file) + " is written"; }

/// The next one that is not there yet, also of an earlier run, and that nobody is writing.
QString freeFile(const char* pattern, int& number) {
  QString file;
  do file = QString(pattern).arg(++number);
  while (QFile::exists(file) || QFile::exists(file + ".part"));
  return file;
}

}  // namespace

PictureFiles::PictureFiles(ViewWidget* view, SceneView& scene,
                           std::function<std::shared_ptr<const RecordedSession>()> session)
    : view_(view), scene_(scene), session_(std::move(session)), what_(new QLabel), progress_(new QProgressBar) {
  setObjectName("video");
  progress_->setFixedWidth(kProgress_px);
  auto* cancelling = new QPushButton("Cancel");
  cancelling->setObjectName("cancel video");
  cancelling->setToolTip("Ends the video, of which no file stays");
  cancelling->setFocusPolicy(Qt::TabFocus);
  connect(cancelling, &QPushButton::clicked, [this] { cancel(); });
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(0, 0, 0, 0);
  row->addWidget(what_);
  row->addWidget(progress_);
  row->addWidget(cancelling);
  hide();
  connect(&drawing_, &QTimer::timeout, [this] { drawNext(); });
}

void PictureFiles::addActions(QMenu* menu, const AddAction& add) {
  add(menu, "&Save picture", Qt::Key_S, "Writes haptic_view_N.png in this folder", [this] { savePicture(); });
  add(menu, "Save p&icture as...", QKeySequence("Ctrl+P"), "The scene alone, without panels and words, of any size",
      [this] { savePictureAs(); });
  add(menu, "Save vi&deo...", QKeySequence("Ctrl+Shift+V"), "Of the recording that is shown, seen from here, as WebM",
      [this] { askForVideo(); });
  filming_ = add(menu, "&Film the window", QKeySequence("Ctrl+Shift+F"),
                 "Writes haptic_film_N.webm in this folder, until it is chosen again", [] {});
  filming_->setCheckable(true);
  connect(filming_, &QAction::toggled, [this](bool on) { setFilming(on); });
}

void PictureFiles::savePicture() {
  const QString file = freeFile("haptic_view_%1.png", pictures_);
  const Result<void> written = writePng(scene_.picture(scene_.snapshot(), 0), file.toStdString());
  emit said(kPicture, written ? isWritten(file) : text(written.error().text()), !written);
}

void PictureFiles::savePictureAs() {
  auto* dialog = new PictureDialog(window(), {"Save picture as", "haptic_scene.png", "Pictures (*.png)"},
                                   {scene_.renderWindow().width_px(), scene_.renderWindow().height_px()});
  connect(dialog, &QDialog::accepted, this, [this, dialog] {
    const Result<void> written = writePng(scene_.scenePicture(dialog->size_px().width(), dialog->size_px().height()),
                                          dialog->file().toStdString());
    view_->update();
    emit said(kPicture, written ? isWritten(dialog->file()) : text(written.error().text()), !written);
  });
  dialog->open();
}

void PictureFiles::askForVideo() {
  if (!session_()) return emit said(kVideo, "open a recording first; the window itself is filmed by Film", true);
  if (video_) return emit said(kVideo, "another video is being made; cancel that first", true);
  const QSize least(RecordingVideo::kMinWidth_px, RecordingVideo::kMinHeight_px);
  auto* dialog = new PictureDialog(
      window(), {"Save video", "haptic_recording.webm", "Videos (*.webm)", least, kVideo_Hz}, kVideo_px);
  connect(dialog, &QDialog::accepted, this,
          [this, dialog] { begin(dialog->file(), dialog->size_px(), dialog->rate_Hz()); });
  dialog->open();
}

void PictureFiles::begin(const QString& file, QSize size_px, int rate_Hz) {
  const auto session = session_();
  if (!session) return;
  auto video = RecordingVideo::begin(session,
                                     {.file = file.toStdString(),
                                      .width_px = size_px.width(),
                                      .height_px = size_px.height(),
                                      .rate_Hz = static_cast<double>(rate_Hz)},
                                     scene_.cameras().look());
  if (!video) return emit said(kVideo, text(video.error().text()), true);
  video_ = *std::move(video);
  videoFile_ = file;
  what_->setText("video");
  progress_->setRange(0, static_cast<int>(video_->pictures()));
  show();
  drawing_.start(0);
}

void PictureFiles::drawNext() {
  const Result<void> drawn = video_->drawNext();
  if (!drawn) return endVideo(text(drawn.error().text()), true);
  progress_->setValue(static_cast<int>(video_->drawn()));
  if (video_->drawn() < video_->pictures()) return;
  const Result<void> written = video_->finish();
  endVideo(written ? isWritten(videoFile_) : text(written.error().text()), !written);
}

void PictureFiles::endVideo(const QString& words, bool isError) {
  drawing_.stop();
  video_.reset();
  hide();
  emit said(kVideo, words, isError);
}

void PictureFiles::cancel() {
  if (!video_) return;
  endVideo("cancelled", false);
}

void PictureFiles::setFilming(bool on) {
  if (on == film_.has_value()) return;
  if (on) {
    const QString file = freeFile("haptic_film_%1.webm", films_);
    const QImage first = windowPicture();
    auto writer = WebmWriter::create(file.toStdString(), first.width(), first.height(), kFilm_Hz);
    if (!writer) {
      filming_->setChecked(false);
      return emit said(kFilm, text(writer.error().text()), true);
    }
    film_.emplace(Film{file, first.size(), *std::move(writer), now_s_, now_s_ - 1 / kFilm_Hz});
    return emit said(kFilm, "the window is filmed, until Film is chosen again", false);
  }
  film(std::max(now_s_, film_->last_s + 1 / kFilm_Hz));  // as it is now
  if (!film_) return;
  const Result<void> written = film_->writer.finish();
  const QString file = film_->file;
  film_.reset();
  emit said(kFilm, written ? isWritten(file) : text(written.error().text()), !written);
}

void PictureFiles::film(double now_s) {
  now_s_ = now_s;
  if (!film_ || now_s - film_->last_s < 1 / kFilm_Hz) return;
  const QImage now = windowPicture().scaled(film_->size_px).convertToFormat(QImage::Format_RGB888);
  const Result<void> written = film_->writer.add(bytesOf(now), now_s - film_->begun_s);
  film_->last_s = now_s;
  if (written) return;
  film_.reset();
  filming_->setChecked(false);
  emit said(kFilm, text(written.error().text()), true);
}

/// Qt does not know what VTK has drawn.
QImage PictureFiles::windowPicture() const {
  QPixmap picture = window()->grab();
  QPainter painter(&picture);
  painter.drawImage(QRect(view_->mapTo(window(), QPoint()), view_->size()), imageOf(scene_.renderWindow().grab()));
  return picture.toImage();
}

void PictureFiles::finish() {
  if (film_) filming_->setChecked(false);
  cancel();
}

}  // namespace haptics

#include "moc_picture_files.cpp"

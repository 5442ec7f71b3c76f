#include "graphics_client/application/recording_video.h"

#include <vtkImageData.h>

#include <QHBoxLayout>
#include <QLabel>
#include <QPainter>
#include <QVBoxLayout>
#include <algorithm>
#include <utility>

#include "common/clock/monotonic.h"
#include "graphics_client/application/plotted_sample.h"
#include "graphics_client/application/time_slider.h"

namespace haptics {
namespace {

/// Of curves and time line: their share of the picture's height, as far as that leaves curves to be read and room.
constexpr double kFootShare = 0.24;
constexpr int kMinFoot_px = 140, kMaxFoot_px = 320;

/// Eleven hours of 25 a second. A damaged recording may seem to last for ages.
constexpr int kMaxPictures = 1'000'000;

int footHeight_px(int height_px) {
  return std::clamp(static_cast<int>(kFootShare * height_px), kMinFoot_px, kMaxFoot_px);
}

ViewerOptions viewerOptions(const VideoOptions& options) {
  ViewerOptions viewer;
  viewer.width_px = options.width_px;
  viewer.height_px = options.height_px - footHeight_px(options.height_px);
  viewer.offscreen = true;
  return viewer;
}

}  // namespace

QImage imageOf(vtkImageData* picture) {
  const int* size = picture->GetDimensions();
  return QImage(static_cast<const uchar*>(picture->GetScalarPointer()), size[0], size[1], 3 * size[0],
                QImage::Format_RGB888)
      .mirrored();
}

Result<std::unique_ptr<RecordingVideo>> RecordingVideo::begin(std::shared_ptr<const RecordedSession> session,
                                                              const VideoOptions& options,
                                                              const std::optional<CameraRig::Look>& look) {
  if (options.width_px < kMinWidth_px || options.height_px < kMinHeight_px) {
    return refused("size", std::to_string(options.width_px) + "x" + std::to_string(options.height_px) +
                               " leaves no room for scene and curves; from " + std::to_string(kMinWidth_px) + "x" +
                               std::to_string(kMinHeight_px) + " on it does");
  }
  if (const double pictures = session->duration_s() * options.rate_Hz; pictures > kMaxPictures) {
    return refused("recording", "goes on for " + std::to_string(session->duration_s()) +
                                    " s by the numbers of its ticks; " + std::to_string(options.rate_Hz) +
                                    " pictures a second are more than the " + std::to_string(kMaxPictures) +
                                    " that a video may have");
  }
  auto writer = WebmWriter::create(options.file, options.width_px, options.height_px, options.rate_Hz);
  if (!writer) return tl::unexpected(std::move(writer).error());
  std::unique_ptr<RecordingVideo> video(new RecordingVideo(std::move(session), options, *std::move(writer)));
  if (look) video->scene_.lookAs(*look);
  return video;
}

RecordingVideo::RecordingVideo(std::shared_ptr<const RecordedSession> session, const VideoOptions& options,
                               WebmWriter writer)
    : session_(std::move(session)),
      rate_Hz_(options.rate_Hz),
      size_px_(options.width_px, options.height_px),
      writer_(std::move(writer)),
      plots_(new PlotPanel),
      slider_(new TimeSlider),
      time_(new QLabel),
      scene_(viewerOptions(options)),
      pictures_(static_cast<std::size_t>(session_->duration_s() * rate_Hz_) + 1) {
  auto* line = new QHBoxLayout;
  line->addWidget(slider_, 1);
  line->addWidget(time_);
  auto* rows = new QVBoxLayout(&foot_);
  rows->setContentsMargins(6, 4, 6, 4);
  rows->setSpacing(2);
  rows->addWidget(plots_, 1);
  rows->addLayout(line);
  slider_->show(session_->duration_s(), session_->marks());
  foot_.setFixedSize(size_px_.width(), footHeight_px(size_px_.height()));
  foot_.setAttribute(Qt::WA_DontShowOnScreen);
  foot_.show();
  if (scene_.overlay().areDetailsVisible()) scene_.overlay().toggleDetails();
}

Result<void> RecordingVideo::drawNext() {
  const double time_s = static_cast<double>(drawn_) / rate_Hz_;
  const std::size_t moment = session_->moments().indexAt(time_s);
  plots_->replace(plottedUntil(session_->moments(), time_s));
  plots_->refresh();
  slider_->setTime(time_s);
  time_->setText(QString("%1 s of %2 s").arg(time_s, 0, 'f', 2).arg(session_->duration_s(), 0, 'f', 2));
  QImage page(size_px_, QImage::Format_RGB888);
  QPainter painter(&page);
  painter.drawImage(0, 0, imageOf(scene_.wholeFrame(session_->view(moment, monotonicNow_ns()), time_s)));
  foot_.render(&painter, QPoint(0, size_px_.height() - foot_.height()));
  painter.end();
  ++drawn_;
  return writer_.add(bytesOf(page), time_s);
}

}  // namespace haptics

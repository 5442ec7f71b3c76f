#include "graphics_client/application/application.h"

#include <QApplication>
#include <clocale>
#include <optional>
#include <stop_token>

#include "common/log/log.h"
#include "graphics_client/application/main_window.h"
#include "graphics_client/application/recording_video.h"
#include "graphics_client/application/theme.h"

namespace haptics {
namespace {

/// Qt's words go where the program's go. That a session without a login has no folder of its own is no trouble here.
void log(QtMsgType type, const QMessageLogContext& /*context*/, const QString& words) {
  if (words.startsWith("QStandardPaths: XDG_RUNTIME_DIR")) return;
  if (words.startsWith("The X11 connection broke")) displayLost();  // Qt would call exit() next
  logAt(type == QtDebugMsg || type == QtInfoMsg ? LogLevel::kDebug : LogLevel::kWarning, words.toStdString());
}

/// Qt, as all that the program shows needs it.
class Application {
 public:
  Application() {
    qputenv("QT_QPA_PLATFORM", "xcb");  // VTK draws into windows of X
    qInstallMessageHandler(log);
    application_.emplace(argc_, argv_);
    std::setlocale(LC_NUMERIC, "C");  // which it has set to the user's: numbers in files and logs have points
    applyTheme();
  }

 private:
  int argc_ = 1;
  char name_[16] = "graphics_client";
  char* argv_[2] = {name_, nullptr};
  std::optional<QApplication> application_;
};

}  // namespace

Result<RunSummary> runApplication(const ViewerOptions& options, std::unique_ptr<ServerLink>& link,
                                  const ViewSource& source, const std::atomic<bool>& stop,
                                  const std::string& recording) {
  const Application application;
  MainWindow window(options, *link, source);
  window.show();
  if (!recording.empty()) window.openRecording(QString::fromStdString(recording));
  QTimer stopping;
  QObject::connect(&stopping, &QTimer::timeout, [&] {
    if (stop) window.end();
  });
  stopping.start(50);
  QApplication::exec();
  window.finish();
  link.reset();
  SceneView& scene = window.scene();
  if (!options.screenshot.empty() && scene.snapshot().view) {
    if (Result<void> written = writePng(scene.finePicture(scene.snapshot()), options.screenshot); !written) {
      return tl::unexpected(written.error());
    }
  }
  return std::move(scene.summary());
}

Result<void> writeVideo(const std::string& recording, const VideoOptions& options, const std::atomic<bool>& stop) {
  constexpr std::size_t kProgressLines = 10;  // times
  const Application application;
  std::stop_source reading;
  auto session = RecordedSession::read(recording, reading.get_token(), [&](double /*share*/) {
    if (stop) reading.request_stop();
  });
  if (!session) return tl::unexpected(std::move(session).error());
  auto begun = RecordingVideo::begin(std::make_shared<const RecordedSession>(*std::move(session)), options, {});
  if (!begun) return tl::unexpected(std::move(begun).error());
  RecordingVideo& video = **begun;
  for (std::size_t said = 0; video.drawn() < video.pictures() && !stop;) {
    if (Result<void> drawn = video.drawNext(); !drawn) return drawn;
    const std::size_t done = kProgressLines * video.drawn() / video.pictures();
    if (done > std::exchange(said, done)) {
      logInfo("video: " + std::to_string(video.drawn()) + " of " + std::to_string(video.pictures()) + " pictures");
    }
  }
  if (stop) return refused(options.file, "was given up after " + std::to_string(video.drawn()) + " pictures");
  return video.finish();
}

}  // namespace haptics

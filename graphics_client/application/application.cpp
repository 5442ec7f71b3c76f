#include "graphics_client/application/application.h"

#include <QApplication>
#include <clocale>

#include "common/log/log.h"
#include "graphics_client/application/main_window.h"
#include "graphics_client/application/theme.h"

namespace haptics {
namespace {

/// Qt's words go where the program's go. That a session without a login has no folder of its own is no trouble here.
void log(QtMsgType type, const QMessageLogContext& /*context*/, const QString& words) {
  if (words.startsWith("QStandardPaths: XDG_RUNTIME_DIR")) return;
  if (words.startsWith("The X11 connection broke")) displayLost();  // Qt would call exit() next
  logAt(type == QtDebugMsg || type == QtInfoMsg ? LogLevel::kDebug : LogLevel::kWarning, words.toStdString());
}

}  // namespace

Result<RunSummary> runApplication(const ViewerOptions& options, std::unique_ptr<ServerLink>& link,
                                  const ViewSource& source, const std::atomic<bool>& stop,
                                  const std::string& recording) {
  int argc = 1;
  char name[] = "graphics_client";
  char* argv[] = {name, nullptr};
  qputenv("QT_QPA_PLATFORM", "xcb");  // VTK draws into windows of X
  qInstallMessageHandler(log);
  QApplication application(argc, argv);
  std::setlocale(LC_NUMERIC, "C");  // which it has set to the user's: numbers in files and logs have points
  applyTheme();
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

}  // namespace haptics

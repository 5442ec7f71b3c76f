#include "graphics_client/application/application.h"

#include <QApplication>

#include "graphics_client/application/main_window.h"

namespace haptics {

Result<RunSummary> runApplication(const ViewerOptions& options, std::unique_ptr<ServerLink>& link,
                                  const ViewSource& source, const std::atomic<bool>& stop) {
  int argc = 1;
  char name[] = "graphics_client";
  char* argv[] = {name, nullptr};
  qputenv("QT_QPA_PLATFORM", "xcb");  // VTK draws into windows of X
  QApplication application(argc, argv);
  MainWindow window(options, *link, source);
  window.show();
  QTimer stopping;
  QObject::connect(&stopping, &QTimer::timeout, [&] {
    if (stop) window.close();
  });
  stopping.start(50);
  QApplication::exec();
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

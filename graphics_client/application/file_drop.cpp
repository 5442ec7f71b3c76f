#include "graphics_client/application/file_drop.h"

#include <QDropEvent>
#include <QMimeData>
#include <QUrl>
#include <QWidget>

namespace haptics {
namespace {

QStringList localFiles(const QMimeData& data) {
  QStringList files;
  for (const QUrl& url : data.urls()) {
    if (url.isLocalFile()) files << url.toLocalFile();
  }
  return files;
}

}  // namespace

FileDrop::FileDrop(QWidget* window) : QObject(window) {
  window->setAcceptDrops(true);
  window->installEventFilter(this);
}

bool FileDrop::eventFilter(QObject* /*window*/, QEvent* event) {
  const bool isDrop = event->type() == QEvent::Drop;
  if (!isDrop && event->type() != QEvent::DragEnter && event->type() != QEvent::DragMove) return false;
  auto& drop = *static_cast<QDropEvent*>(event);  // the base class of the other two
  const QStringList files = localFiles(*drop.mimeData());
  if (files.isEmpty()) return false;
  drop.setDropAction(Qt::CopyAction);
  drop.accept();
  if (isDrop) emit dropped(files, drop.pos());
  return true;
}

}  // namespace haptics

#include "moc_file_drop.cpp"

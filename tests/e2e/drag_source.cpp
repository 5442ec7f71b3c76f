// A window in the lower left corner of a screen of 1280 x 1024 pixels out of which a file is dragged: drag_source FILE.
#include <QApplication>
#include <QDrag>
#include <QLabel>
#include <QMimeData>
#include <QMouseEvent>
#include <QUrl>

namespace {

class Source : public QLabel {
 public:
  explicit Source(const QString& file) : QLabel("drag me"), file_(file) {}

 protected:
  void mousePressEvent(QMouseEvent* /*event*/) override {
    auto* files = new QMimeData;
    files->setUrls({QUrl::fromLocalFile(file_)});
    auto* drag = new QDrag(this);
    drag->setMimeData(files);
    drag->exec(Qt::CopyAction);
  }

 private:
  QString file_;
};

}  // namespace

int main(int argc, char** argv) {
  QApplication application(argc, argv);
  Source source(QApplication::arguments().value(1));
  source.setWindowTitle("Drag source");
  source.setWindowFlag(Qt::X11BypassWindowManagerHint);
  source.setGeometry(0, 960, 60, 60);
  source.show();
  return QApplication::exec();
}

#include "graphics_client/application/view_widget.h"

#include <QHelpEvent>
#include <QMouseEvent>
#include <QTabletEvent>
#include <QTimer>
#include <QToolTip>
#include <QWheelEvent>
#include <cmath>
#include <utility>

namespace haptics {
namespace {

constexpr double kZoomPerClick = 1.12;
constexpr double kAngleOfClick = 120;  // QWheelEvent's eighths of a degree
constexpr int kMoved_px = 4, kResized_ms = 100;

}  // namespace

ViewWidget::ViewWidget(SceneView& scene) : scene_(scene) {
  setAttribute(Qt::WA_NativeWindow);
  setAttribute(Qt::WA_PaintOnScreen);
  setAttribute(Qt::WA_NoSystemBackground);
  setMouseTracking(true);
  setFocusPolicy(Qt::StrongFocus);
  setMinimumSize(320, 240);
  setObjectName("view");
}

bool ViewWidget::event(QEvent* event) {
  if (event->type() != QEvent::ToolTip) return QWidget::event(event);
  const auto* help = static_cast<QHelpEvent*>(event);
  const double ratio = devicePixelRatioF();
  const std::string tip =
      scene_.overlay().tipAt(ratio * help->x(), scene_.renderWindow().height_px() - ratio * help->y());
  QToolTip::showText(help->globalPos(), QString::fromStdString(tip), this);
  return true;
}

bool ViewWidget::takeDirty() { return std::exchange(dirty_, false); }

void ViewWidget::showEvent(QShowEvent* /*event*/) {
  if (std::exchange(embedded_, true)) return;
  scene_.renderWindow().embedIn(winId());
  resizeEvent(nullptr);
}

void ViewWidget::paintEvent(QPaintEvent* /*event*/) { dirty_ = true; }

void ViewWidget::resizeEvent(QResizeEvent* /*event*/) {
  const double ratio = devicePixelRatioF();
  scene_.renderWindow().resize(static_cast<int>(width() * ratio), static_cast<int>(height() * ratio));
  dirty_ = true;
  // The X server may not have resized the window when the next frame is drawn.
  QTimer::singleShot(kResized_ms, this, [this] { dirty_ = true; });
}

void ViewWidget::follow(const QPointF& place) {
  const double ratio = devicePixelRatioF();
  pointer_ = Pixel{static_cast<int>(std::lround(place.x() * ratio)),
                   scene_.renderWindow().height_px() - 1 - static_cast<int>(std::lround(place.y() * ratio))};
  dirty_ = true;
}

void ViewWidget::mousePressEvent(QMouseEvent* event) {
  follow(event->localPos());
  last_ = pressedAt_ = event->pos();
  if (event->button() != Qt::LeftButton) return;
  pressed_ = true;
  emit pressed();
}

void ViewWidget::mouseReleaseEvent(QMouseEvent* event) {
  if (event->button() != Qt::LeftButton) return;
  pressed_ = false;
  penPressure_.reset();
  emit released((event->pos() - pressedAt_).manhattanLength() > kMoved_px);
}

void ViewWidget::mouseMoveEvent(QMouseEvent* event) {
  const QPoint way = (event->pos() - last_) * devicePixelRatioF();
  last_ = event->pos();
  if (pressed_ && (event->modifiers() & Qt::ShiftModifier) != 0) return emit turned(way.x(), -way.y());
  follow(event->localPos());
  if ((event->buttons() & Qt::RightButton) != 0) scene_.cameras().orbit(way.x(), -way.y());
  if ((event->buttons() & Qt::MiddleButton) != 0) scene_.cameras().pan(way.x(), -way.y());
}

void ViewWidget::wheelEvent(QWheelEvent* event) {
  const double clicks = event->angleDelta().y() / kAngleOfClick;
  if ((event->modifiers() & Qt::ControlModifier) != 0) {
    emit gripperTurned(clicks);
  } else if (pressed_) {
    emit wheelTurned(clicks);
  } else {
    scene_.cameras().zoom(std::pow(kZoomPerClick, clicks));
    dirty_ = true;
  }
}

/// The events of the mouse that follow from it lead the hand; this adds how hard the pen presses.
void ViewWidget::tabletEvent(QTabletEvent* event) {
  penPressure_ = event->pressure() > 0 ? std::optional(event->pressure()) : std::nullopt;
  event->ignore();
}

void ViewWidget::leaveEvent(QEvent* /*event*/) {
  if (!pressed_) pointer_.reset();
}

}  // namespace haptics

#include "moc_view_widget.cpp"

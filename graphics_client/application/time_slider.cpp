#include "graphics_client/application/time_slider.h"

#include <QHelpEvent>
#include <QMouseEvent>
#include <QPainter>
#include <QSignalBlocker>
#include <QToolTip>
#include <algorithm>
#include <cmath>

namespace haptics {
namespace {

constexpr int kTimeSteps = 100'000;  // of the whole time line
constexpr int kMargin_px = 8, kMark_px = 5, kNear_px = 4;

}  // namespace

TimeSlider::TimeSlider() : QSlider(Qt::Horizontal) {
  setObjectName("time");
  setRange(0, kTimeSteps);
  setPageStep(kTimeSteps / 20);
  setSingleStep(kTimeSteps / 200);
  setMinimumHeight(26);
  connect(this, &QSlider::valueChanged, [this](int value) { emit sought(duration_s_ * value / kTimeSteps); });
}

void TimeSlider::show(double duration_s, const std::vector<RecordedSession::Mark>& marks) {
  duration_s_ = duration_s;
  marks_ = marks;
  setTime(0);
  update();
}

void TimeSlider::setTime(double time_s) {
  const QSignalBlocker quiet(this);
  setValue(duration_s_ > 0 ? static_cast<int>(std::lround(kTimeSteps * time_s / duration_s_)) : 0);
}

double TimeSlider::timeAt(int x) const {
  const double share = static_cast<double>(x - kMargin_px) / std::max(1, width() - 2 * kMargin_px);
  return duration_s_ * std::clamp(share, 0.0, 1.0);
}

int TimeSlider::xOf(double time_s) const {
  if (duration_s_ <= 0) return kMargin_px;
  return kMargin_px + static_cast<int>(std::lround(time_s / duration_s_ * (width() - 2 * kMargin_px)));
}

void TimeSlider::paintEvent(QPaintEvent* /*event*/) {
  QPainter painter(this);
  painter.setRenderHint(QPainter::Antialiasing);
  const int middle = height() / 2, now = xOf(duration_s_ * value() / kTimeSteps);
  const auto line = [&](int from, int to, const QColor& color) {
    painter.setPen(QPen(color, 4, Qt::SolidLine, Qt::RoundCap));
    painter.drawLine(from, middle, to, middle);
  };
  line(kMargin_px, width() - kMargin_px, palette().color(QPalette::Mid));
  line(kMargin_px, now, palette().color(QPalette::Highlight));
  painter.setPen(Qt::NoPen);
  for (const RecordedSession::Mark& mark : marks_) {
    painter.setBrush(mark.isFault ? QColor(200, 30, 30) : QColor(20, 110, 60));
    const QRect above(xOf(mark.time_s) - 1, 0, 3, middle - kMark_px), below = above.translated(0, middle + kMark_px);
    painter.drawRect(mark.isFault ? below : above);
  }
  painter.setBrush(palette().color(QPalette::Button));
  painter.setPen(palette().color(hasFocus() ? QPalette::Highlight : QPalette::Dark));
  painter.drawEllipse(QPoint(now, middle), 6, 6);
}

/// The tool tip names the marks under the pointer.
bool TimeSlider::event(QEvent* event) {
  if (event->type() != QEvent::ToolTip) return QSlider::event(event);
  const auto* help = dynamic_cast<QHelpEvent*>(event);
  QString words = QString("%1 s").arg(timeAt(help->x()), 0, 'f', 2);
  for (const RecordedSession::Mark& mark : marks_) {
    if (std::abs(xOf(mark.time_s) - help->x()) > kNear_px) continue;
    words += QString("\n%1 s: %2").arg(mark.time_s, 0, 'f', 2).arg(QString::fromStdString(mark.text));
    if (words.size() > 300) break;
  }
  QToolTip::showText(help->globalPos(), words, this);
  return true;
}

void TimeSlider::mousePressEvent(QMouseEvent* event) {
  if (event->button() != Qt::LeftButton) return;
  const double time_s = timeAt(event->x());
  setTime(time_s);
  emit sought(time_s);
}

void TimeSlider::mouseMoveEvent(QMouseEvent* event) {
  if ((event->buttons() & Qt::LeftButton) == 0) return;
  const double time_s = timeAt(event->x());
  setTime(time_s);
  emit sought(time_s);
}

}  // namespace haptics

#include "moc_time_slider.cpp"

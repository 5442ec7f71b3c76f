#pragma once

#include <QSlider>
#include <vector>

#include "graphics_client/session/recorded_session.h"

namespace haptics {

/// A recording's time line, with a mark for each edit, fault and press of a button that marks. A click goes there.
class TimeSlider : public QSlider {
  Q_OBJECT

 public:
  TimeSlider();

  void show(double duration_s, const std::vector<RecordedSession::Mark>& marks);
  void setTime(double time_s);

 signals:
  /// By a person.
  void sought(double time_s);

 protected:
  bool event(QEvent* event) override;
  void paintEvent(QPaintEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;

 private:
  double duration_s_ = 0;
  std::vector<RecordedSession::Mark> marks_;

  [[nodiscard]] double timeAt(int x) const;
  [[nodiscard]] int xOf(double time_s) const;
};

}  // namespace haptics

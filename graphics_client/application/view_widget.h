#pragma once

#include <QWidget>
#include <functional>
#include <optional>

#include "graphics_client/viewer/scene_view.h"

namespace haptics {

/// The picture of the scene, in a window of the X server of its own, and the pointer on it. The right button orbits, the
/// middle one pans; what the left one and the wheel do is the owner's.
class ViewWidget : public QWidget {
  Q_OBJECT

 public:
  explicit ViewWidget(SceneView& scene);

  /// Where the pointer is, if over the picture.
  [[nodiscard]] std::optional<Pixel> pointer() const { return pointer_; }
  [[nodiscard]] bool isPressed() const { return pressed_; }
  /// 0 to 1, of a tablet's pen while it touches; nothing: of a mouse.
  [[nodiscard]] std::optional<double> penPressure() const { return penPressure_; }
  /// As if the pointer were there, in this widget.
  void pointTo(const QPoint& place) { follow(place); }
  /// Something moved the camera or the picture since the last call.
  [[nodiscard]] bool takeDirty();

 signals:
  void pressed();
  void released(bool moved);
  void wheelTurned(double clicks);
  /// With Ctrl down.
  void gripperTurned(double clicks);
  /// With the left button and Shift down; pointer() stays.
  void turned(double right_px, double up_px);

 protected:
  /// What the line of words under the pointer means.
  bool event(QEvent* event) override;
  QPaintEngine* paintEngine() const override { return nullptr; }
  void paintEvent(QPaintEvent* event) override;
  void showEvent(QShowEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;
  void tabletEvent(QTabletEvent* event) override;
  void leaveEvent(QEvent* event) override;

 private:
  SceneView& scene_;
  std::optional<Pixel> pointer_;
  QPoint last_, pressedAt_;
  bool pressed_ = false, embedded_ = false, dirty_ = true;
  std::optional<double> penPressure_;

  void follow(const QPointF& place);
};

}  // namespace haptics

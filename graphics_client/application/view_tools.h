#pragma once

#include <QObject>
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "graphics_client/viewer/scene_view.h"

class QAction;
class QKeySequence;
class QMenu;

namespace haptics {

/// From where the picture is seen, what is measured in it, and what is cut away.
class ViewTools : public QObject {
  Q_OBJECT

 public:
  static constexpr int kKeptLooks = 4;

  explicit ViewTools(SceneView& scene) : scene_(scene) {}

  /// As MainWindow::addAction().
  using AddAction = std::function<QAction*(QMenu*, const QString& title, const QKeySequence& key, const QString& tip,
                                           std::function<void()> does)>;
  void addLooks(QMenu* menu, const AddAction& add);
  void addTools(QMenu* menu, const AddAction& add);

  /// What is cut through; empty: all objects.
  void select(std::string object) { selected_ = std::move(object); }
  [[nodiscard]] bool isMeasuring() const { return measuring_; }
  void measureAt(const SurfacePoint& place);
  /// In words, with the place under the pointer.
  [[nodiscard]] QString measured() const;

 signals:
  /// The picture is another one.
  void changed();
  /// The pointer is for measuring from now on.
  void measuring();

 private:
  SceneView& scene_;
  std::string selected_;
  bool measuring_ = false;
  std::vector<Vec3> measured_;
  std::optional<CutPlane> cut_;

  void addKeptLooks(QMenu* menu, const AddAction& add);
  void measure(bool on);
  void cut(bool on);
  void moveCut(double way_m);
};

}  // namespace haptics

#pragma once

#include <QObject>
#include <QPoint>
#include <QStringList>

class QWidget;

namespace haptics {

/// Files of this machine that are dropped onto a window.
class FileDrop : public QObject {
  Q_OBJECT

 public:
  explicit FileDrop(QWidget* window);

 signals:
  /// @param place  In the window.
  void dropped(const QStringList& files, const QPoint& place);

 protected:
  bool eventFilter(QObject* window, QEvent* event) override;
};

}  // namespace haptics

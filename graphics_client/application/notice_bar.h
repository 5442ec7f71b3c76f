#pragma once

#include <QFrame>

class QLabel;
class QPushButton;

namespace haptics {

/// A line over the picture that cannot be overlooked, with a button. Hidden while it has nothing to say; what it says
/// is logged.
class NoticeBar : public QFrame {
  Q_OBJECT

 public:
  NoticeBar(const QString& name, const QString& button, const QString& tip);

  /// @param words  Empty: nothing.
  void say(const QString& words, bool isError);

 signals:
  void clicked();

 private:
  QLabel* words_;
};

}  // namespace haptics

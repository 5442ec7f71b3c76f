#pragma once

#include <QDialog>
#include <QLineEdit>
#include <QSpinBox>

namespace haptics {

/// Asks for the file of a picture, and its size in pixels.
class PictureDialog : public QDialog {
 public:
  PictureDialog(QWidget* parent, QSize size_px);

  [[nodiscard]] QString file() const { return file_->text().trimmed(); }
  [[nodiscard]] QSize size_px() const { return {width_->value(), height_->value()}; }

 private:
  QLineEdit* file_;
  QSpinBox *width_, *height_;
};

}  // namespace haptics

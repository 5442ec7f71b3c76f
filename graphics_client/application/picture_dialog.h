#pragma once

#include <QDialog>
#include <QLineEdit>
#include <QSpinBox>
#include <string>

namespace haptics {

/// Asks for the file of a picture or video, its size in pixels, and a video's pictures of a second.
class PictureDialog : public QDialog {
 public:
  struct Kind {
    QString title, file, filter;
    QSize least_px{64, 64};
    int rate_Hz = 0;  ///< That is offered; 0: it is no video.
  };
  PictureDialog(QWidget* parent, const Kind& kind, QSize size_px);

  [[nodiscard]] QString file() const { return file_->text().trimmed(); }
  [[nodiscard]] QSize size_px() const { return {width_->value(), height_->value()}; }
  [[nodiscard]] int rate_Hz() const { return rate_->value(); }

  /// Says so where the name has another ending than `Kind::file`. Asks first whether to replace a file that is there, unless its choice was asked about.
  void accept() override;

 private:
  std::string ending_;  // of the kind
  QString chosen_;      // by the dialog for files, which asks
  QLineEdit* file_;
  QSpinBox *width_, *height_, *rate_;
};

}  // namespace haptics

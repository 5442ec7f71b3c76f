#include "graphics_client/application/picture_dialog.h"

#include <QDialogButtonBox>
#include <QFileDialog>
#include <QFileInfo>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QMessageBox>
#include <QPushButton>

#include "common/process/pending_file.h"

namespace haptics {
namespace {

/// Side of a picture: what software rendering draws with its buffers in some hundred megabytes.
constexpr int kLargest_px = 8192;
constexpr int kFastest_Hz = 120;

QSpinBox* field(const QString& name, int value, int least, int most, const QString& unit) {
  auto* field = new QSpinBox;
  field->setRange(least, most);
  field->setValue(value);
  field->setSuffix(" " + unit);
  field->setAccessibleName(name);
  return field;
}

}  // namespace

PictureDialog::PictureDialog(QWidget* parent, const Kind& kind, QSize size_px)
    : QDialog(parent),
      ending_("." + QFileInfo(kind.file).suffix().toStdString()),
      file_(new QLineEdit(kind.file)),
      width_(field("width", size_px.width(), kind.least_px.width(), kLargest_px, "px")),
      height_(field("height", size_px.height(), kind.least_px.height(), kLargest_px, "px")),
      rate_(field("pictures of a second", kind.rate_Hz, 1, kFastest_Hz, "Hz")) {
  setWindowTitle(kind.title);
  setAttribute(Qt::WA_DeleteOnClose);
  file_->setAccessibleName("file");
  auto* browse = new QPushButton("Browse...");
  browse->setAutoDefault(false);
  connect(browse, &QPushButton::clicked, [this, kind] {
    const QString chosen = QFileDialog::getSaveFileName(this, kind.title, file(), kind.filter);
    if (chosen.isEmpty()) return;
    file_->setText(chosen);
    chosen_ = file();
  });
  auto* place = new QHBoxLayout;
  place->addWidget(file_, 1);
  place->addWidget(browse);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Save | QDialogButtonBox::Cancel);
  connect(buttons, &QDialogButtonBox::accepted, this, &QDialog::accept);
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  auto* form = new QFormLayout(this);
  form->addRow("File", place);
  form->addRow("&Width", width_);
  form->addRow("&Height", height_);
  form->addRow("&Pictures of a second", rate_);
  rate_->setVisible(kind.rate_Hz > 0);
  form->labelForField(rate_)->setVisible(kind.rate_Hz > 0);
  form->addRow(buttons);
  buttons->button(QDialogButtonBox::Save)->setDefault(true);
  file_->setFocus();
  file_->selectAll();
  resize(460, 0);
}

void PictureDialog::accept() {
  if (const auto named = checkEnding(file().toStdString(), ending_); !named) {
    auto* refusal = new QMessageBox(QMessageBox::Warning, windowTitle(), QString::fromStdString(named.error().text()),
                                    QMessageBox::Ok, this);
    refusal->setAttribute(Qt::WA_DeleteOnClose);
    refusal->setTextFormat(Qt::PlainText);
    return refusal->open();
  }
  if (!QFileInfo::exists(file()) || file() == chosen_) return QDialog::accept();
  auto* question = new QMessageBox(QMessageBox::Question, windowTitle(), file() + " is there already. Replace it?",
                                   QMessageBox::Yes | QMessageBox::No, this);
  question->setAttribute(Qt::WA_DeleteOnClose);
  question->setTextFormat(Qt::PlainText);
  question->setDefaultButton(QMessageBox::No);
  connect(question, &QMessageBox::finished, this, [this](int answer) {
    if (answer == QMessageBox::Yes) QDialog::accept();
  });
  question->open();
}

}  // namespace haptics

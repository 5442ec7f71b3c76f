#include "graphics_client/application/picture_dialog.h"

#include <QDialogButtonBox>
#include <QFileDialog>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QPushButton>

namespace haptics {
namespace {

/// Sides of a picture: what software rendering draws with its buffers in some hundred megabytes.
constexpr int kSmallest_px = 64, kLargest_px = 8192;

QSpinBox* sideField(const QString& name, int side_px) {
  auto* field = new QSpinBox;
  field->setRange(kSmallest_px, kLargest_px);
  field->setValue(side_px);
  field->setSuffix(" px");
  field->setAccessibleName(name);
  return field;
}

}  // namespace

PictureDialog::PictureDialog(QWidget* parent, QSize size_px)
    : QDialog(parent),
      file_(new QLineEdit("haptic_scene.png")),
      width_(sideField("width", size_px.width())),
      height_(sideField("height", size_px.height())) {
  setWindowTitle("Save picture as");
  setAttribute(Qt::WA_DeleteOnClose);
  file_->setAccessibleName("file");
  auto* browse = new QPushButton("Browse...");
  browse->setAutoDefault(false);
  connect(browse, &QPushButton::clicked, [this] {
    const QString chosen = QFileDialog::getSaveFileName(this, "Save picture as", file(), "Pictures (*.png)");
    if (!chosen.isEmpty()) file_->setText(chosen);
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
  form->addRow(buttons);
  buttons->button(QDialogButtonBox::Save)->setDefault(true);
  file_->setFocus();
  file_->selectAll();
  resize(460, 0);
}

}  // namespace haptics

#include "graphics_client/application/property_rows.h"

#include <QAbstractItemView>
#include <QCheckBox>
#include <QColorDialog>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QGridLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QSignalBlocker>
#include <QSlider>
#include <QToolButton>
#include <algorithm>
#include <cmath>
#include <utility>

namespace haptics {
namespace {

/// Of what may be typed into a field, in the unit that it shows.
constexpr double kLargest = 1e6;
/// The server has answered a change by then, as a rule: before, the row does not go back to the value before.
constexpr int kAnswered_ms = 500;

/// Black has the contrast to it that white has: 4.58 (WCAG 2.1).
constexpr double kMiddleLuminance = 0.179;

constexpr int kGap_px = 6;

QString nameOf(const char* label) { return QString::fromUtf8(label); }

}  // namespace

SetProperty setterOf(const NumberProperty& number, double value) {
  return [label = std::string(number.label), get = number.get, set = number.set, value](
             const ObjectRecord& object, const Surroundings& /*around*/, v1::Operation& operation) -> Result<void> {
    if (!get(object)) return refused(label, "the object has none any more");
    set(object, value, operation);
    return {};
  };
}

NumberRow::NumberRow(const NumberProperty& number, QFormLayout* form, std::function<void(double)> change,
                     const std::function<void()>& finished)
    : number_(number),
      row_(new QWidget),
      box_(new QDoubleSpinBox),
      slider_(new QSlider(Qt::Horizontal)),
      reset_(new QToolButton) {
  box_->setObjectName(number.label);
  box_->setDecimals(number.decimals);
  box_->setSuffix(QString::fromUtf8(number.unit));
  box_->setRange(number.least, number.most);
  box_->setMaximumWidth(box_->sizeHint().width());
  box_->setRange(-kLargest, kLargest);
  box_->setStepType(QAbstractSpinBox::AdaptiveDecimalStepType);
  box_->setKeyboardTracking(false);
  box_->setToolTip(number.tip);
  box_->setAccessibleName(number.label);
  slider_->setObjectName(nameOf(number.label) + " slider");
  slider_->setRange(0, kSteps);
  slider_->setToolTip(number.tip);
  slider_->setAccessibleName(nameOf(number.label) + " slider");
  reset_->setText("\u21ba");
  reset_->setAutoRaise(true);
  reset_->setToolTip("Back to what it was when the object was selected");
  reset_->setAccessibleName(nameOf(number.label) + " reset");
  auto* label = new QLabel(number.label);
  label->setToolTip(number.tip);
  auto* layout = new QGridLayout(row_);
  layout->setContentsMargins(0, 0, 0, number.isHidden ? kGap_px : 0);  // a form leaves a gap where a row is hidden
  layout->setVerticalSpacing(0);
  layout->addWidget(label, 0, 0);
  layout->addWidget(box_, 0, 1);
  layout->addWidget(reset_, 0, 2);
  layout->addWidget(slider_, 1, 0, 1, 3);
  layout->setColumnStretch(0, 1);
  form->addRow(row_);
  const auto changeTo = [this, change = std::move(change)](double value) {
    isTyping_ = false;
    sinceChange_.start();
    show(value);
    change(value);
  };
  QObject::connect(slider_, &QSlider::valueChanged, [this, changeTo](int step) { changeTo(valueAt(step)); });
  QObject::connect(slider_, &QSlider::sliderReleased, finished);
  QObject::connect(reset_, &QToolButton::clicked, [this, changeTo, finished] {
    if (!first_) return;
    changeTo(*first_);
    finished();
  });
  QObject::connect(box_->findChild<QLineEdit*>(), &QLineEdit::textEdited, [this] { isTyping_ = true; });
  QObject::connect(box_, &QDoubleSpinBox::editingFinished, [this] { isTyping_ = false; });
  QObject::connect(box_, QOverload<double>::of(&QDoubleSpinBox::valueChanged), [changeTo, finished](double value) {
    changeTo(value);
    finished();
  });
}

bool NumberRow::isHeld() const {
  return slider_->isSliderDown() || isTyping_ || (sinceChange_.isValid() && sinceChange_.elapsed() < kAnswered_ms);
}

void NumberRow::show(const ObjectRecord& object, const MirrorView& view) {
  const std::optional<double> value = number_.get(object);
  row_->setVisible(value || !number_.isHidden);
  box_->setEnabled(value.has_value());
  slider_->setEnabled(value.has_value());
  const std::pair of{view.epoch, object.id};  // another server has objects of the same numbers
  if (of_ != of || (value && !first_)) first_ = value;
  of_ = of;
  reset_->setEnabled(value && first_ && *value != *first_);
  isTyping_ = false;
  show(value.value_or(number_.least));
}

void NumberRow::show(double value) {
  const QSignalBlocker quietBox(box_), quietSlider(slider_);
  box_->setValue(value);
  slider_->setValue(stepAt(value));
}

double NumberRow::valueAt(int step) const {
  const double share = double(step) / kSteps;
  return number_.logarithmic ? number_.least * std::pow(number_.most / number_.least, share)
                             : number_.least + share * (number_.most - number_.least);
}

int NumberRow::stepAt(double value) const {
  const double within = std::clamp(value, number_.least, number_.most);
  const double share = number_.logarithmic ? std::log(within / number_.least) / std::log(number_.most / number_.least)
                                           : (within - number_.least) / (number_.most - number_.least);
  return static_cast<int>(std::lround(kSteps * share));
}

SwitchRow::SwitchRow(const SwitchProperty& property, QFormLayout* form, const std::function<void(bool)>& change)
    : property_(property), box_(new QCheckBox(property.label)) {
  box_->setObjectName(property.label);
  box_->setToolTip(property.tip);
  box_->setAccessibleName(property.label);
  form->addRow(box_);
  QObject::connect(box_, &QCheckBox::clicked, change);
}

void SwitchRow::show(const ObjectRecord& object, const MirrorView& /*view*/) {
  box_->setVisible(property_.isThere == nullptr || property_.isThere(object));
  box_->setChecked(property_.get(object));
}

ChoiceRow::ChoiceRow(const ChoiceProperty& property, QFormLayout* form, const std::function<void(std::size_t)>& change)
    : property_(property), box_(new QComboBox) {
  box_->setObjectName(property.label);
  box_->setToolTip(property.tip);
  box_->setAccessibleName(property.label);
  for (const std::string& entry : property.entries) box_->addItem(QString::fromStdString(entry));
  form->addRow(property.label, box_);
  QObject::connect(box_, QOverload<int>::of(&QComboBox::activated),
                   [change](int entry) { change(static_cast<std::size_t>(entry)); });
}

void ChoiceRow::show(const ObjectRecord& object, const MirrorView& /*view*/) {
  const auto entry = property_.get(object);
  box_->setEnabled(entry.has_value());
  box_->setCurrentIndex(static_cast<int>(entry.value_or(0)));
}

bool ChoiceRow::isHeld() const { return box_->view()->isVisible(); }

ColorRow::ColorRow(QFormLayout* form, const std::function<void(std::array<int, 3>)>& change)
    : button_(new QPushButton) {
  button_->setObjectName("colour");
  button_->setAccessibleName("colour");
  button_->setToolTip("Of the object in the picture; it is not felt");
  form->addRow("colour", button_);
  QObject::connect(button_, &QPushButton::clicked, [this, change] {
    const QColor chosen =
        QColorDialog::getColor(QColor(shown_[0], shown_[1], shown_[2]), button_->window(), "Colour of the object");
    if (chosen.isValid()) change({chosen.red(), chosen.green(), chosen.blue()});
  });
}

void ColorRow::show(const ObjectRecord& object, const MirrorView& /*view*/) {
  const auto now = shownColor(object.material.color);
  if (now == shown_ && !button_->text().isEmpty()) return;
  shown_ = now;
  const QColor color(now[0], now[1], now[2]);
  const Color& light = object.material.color;
  const double luminance = 0.2126 * light.red + 0.7152 * light.green + 0.0722 * light.blue;
  button_->setText(color.name());
  button_->setStyleSheet(
      QString("background-color: %1; color: %2").arg(color.name(), luminance > kMiddleLuminance ? "black" : "white"));
}

NameAndSizeRow::NameAndSizeRow(QFormLayout* form, const std::function<void(const QString&)>& rename,
                               const std::function<void(double longest_m)>& scale)
    : name_(new QLineEdit), size_(new QDoubleSpinBox) {
  name_->setObjectName("name");
  name_->setAccessibleName("name");
  name_->setToolTip("Letters, digits, _ - and .; no other object may have it");
  form->addRow("name", name_);
  size_->setObjectName("size");
  size_->setAccessibleName("size");
  size_->setToolTip("Longest side of the box around the mesh: the object is scaled");
  size_->setSuffix(" mm");
  size_->setDecimals(2);
  size_->setRange(0.01, kLargest);
  size_->setKeyboardTracking(false);
  size_->setStepType(QAbstractSpinBox::AdaptiveDecimalStepType);
  form->addRow("size", size_);
  QObject::connect(name_, &QLineEdit::editingFinished, [this, rename] {
    if (name_->text() != shownName_) rename(name_->text());
  });
  QObject::connect(size_, QOverload<double>::of(&QDoubleSpinBox::valueChanged), [this, scale](double value) {
    if (shown_mm_ > 0) scale(1e-3 * value);
  });
}

void NameAndSizeRow::show(const ObjectRecord& object, const MirrorView& view) {
  shownName_ = QString::fromStdString(object.name);
  name_->setText(shownName_);
  const auto mesh = view.meshes.find(object.mesh);
  size_->setEnabled(mesh != view.meshes.end());
  if (mesh == view.meshes.end()) {
    shownMesh_ = {};
    return;
  }
  if (shownMesh_ != object.mesh) {
    shownMesh_ = object.mesh;
    shown_mm_ = 1e3 * boxOf(*mesh->second).longest_m();
  }
  const QSignalBlocker quiet(size_);
  size_->setValue(shown_mm_);
}

bool NameAndSizeRow::isHeld() const { return name_->hasFocus() || size_->hasFocus(); }

}  // namespace haptics

#include "graphics_client/application/property_rows.h"

#include <QCheckBox>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLineEdit>
#include <QSignalBlocker>
#include <QSlider>
#include <algorithm>
#include <cmath>
#include <utility>

namespace haptics {
namespace {

/// Of what may be typed into a field, in the unit that it shows.
constexpr double kLargest = 1e6;
/// The server has answered a change by then, as a rule: before, the row does not go back to the value before.
constexpr int kAnswered_ms = 500;

QString nameOf(const char* label) { return QString::fromUtf8(label); }

}  // namespace

NumberRow::NumberRow(const NumberProperty& number, QFormLayout* form, std::function<void(double)> change,
                     const std::function<void()>& finished)
    : number_(number), box_(new QDoubleSpinBox), slider_(new QSlider(Qt::Horizontal)) {
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
  slider_->setMinimumWidth(60);
  slider_->setToolTip(number.tip);
  slider_->setAccessibleName(nameOf(number.label) + " slider");
  auto* row = new QWidget;
  auto* layout = new QHBoxLayout(row);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(slider_, 1);
  layout->addWidget(box_);
  form->addRow(number.label, row);
  const auto changeTo = [this, change = std::move(change)](double value) {
    isTyping_ = false;
    sinceChange_.start();
    show(value);
    change(value);
  };
  QObject::connect(slider_, &QSlider::valueChanged, [this, changeTo](int step) { changeTo(valueAt(step)); });
  QObject::connect(slider_, &QSlider::sliderReleased, finished);
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

void NumberRow::show(const ObjectRecord& object, const MirrorView& /*view*/) {
  const std::optional<double> value = number_.get(object);
  box_->setEnabled(value.has_value());
  slider_->setEnabled(value.has_value());
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
  box_->setChecked(property_.get(object));
}

}  // namespace haptics

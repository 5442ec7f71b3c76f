#pragma once

#include <QElapsedTimer>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "common/scene/scene.h"
#include "graphics_client/application/object_properties.h"
#include "graphics_client/mirror/mirror_view.h"

class QCheckBox;
class QComboBox;
class QDoubleSpinBox;
class QFormLayout;
class QLineEdit;
class QPushButton;
class QSlider;
class QToolButton;

namespace haptics {

/// Makes an operation of an object as earlier edits have left it. Refused: it cannot be made of that.
using SetProperty = std::function<Result<void>(const ObjectRecord&, const Surroundings&, v1::Operation&)>;
/// It may outlive the property.
[[nodiscard]] SetProperty setterOf(const NumberProperty& number, double value);

/// One property of an object.
class PropertyRow {
 public:
  virtual ~PropertyRow() = default;
  /// @param view  That holds the object.
  virtual void show(const ObjectRecord& object, const MirrorView& view) = 0;
  /// By a person: what is shown is left as it is.
  [[nodiscard]] virtual bool isHeld() const = 0;
};

/// A slider and a field for a number. The field takes what the slider does not: the server decides on it. One that may be hidden
/// has the gap below it in itself: its form has none.
class NumberRow : public PropertyRow {
 public:
  /// @param change    Called while the slider is dragged, and when the field is left.
  /// @param finished  The slider or the field is let go of.
  NumberRow(const NumberProperty& number, QFormLayout* form, std::function<void(double)> change,
            const std::function<void()>& finished);

  void show(const ObjectRecord& object, const MirrorView& view) override;
  [[nodiscard]] bool isHeld() const override;

 private:
  static constexpr int kSteps = 1000;

  const NumberProperty& number_;
  QWidget* row_;
  QDoubleSpinBox* box_;
  QSlider* slider_;
  QToolButton* reset_;
  std::optional<std::pair<std::uint64_t, ObjectId>> of_;  // epoch and object that are shown
  std::optional<double> first_;                           // its value when it was first shown
  bool isTyping_ = false;
  QElapsedTimer sinceChange_;  // by a person; not valid before the first

  void show(double value);
  [[nodiscard]] double valueAt(int step) const;
  [[nodiscard]] int stepAt(double value) const;
};

/// A check box for what an object has or has not.
class SwitchRow : public PropertyRow {
 public:
  SwitchRow(const SwitchProperty& property, QFormLayout* form, const std::function<void(bool)>& change);

  void show(const ObjectRecord& object, const MirrorView& view) override;
  [[nodiscard]] bool isHeld() const override { return false; }

 private:
  const SwitchProperty& property_;
  QCheckBox* box_;
};

/// A list to choose from.
class ChoiceRow : public PropertyRow {
 public:
  ChoiceRow(const ChoiceProperty& property, QFormLayout* form, const std::function<void(std::size_t)>& change);

  void show(const ObjectRecord& object, const MirrorView& view) override;
  [[nodiscard]] bool isHeld() const override;

 private:
  const ChoiceProperty& property_;
  QComboBox* box_;
};

/// A button in the object's colour that asks for another.
class ColorRow : public PropertyRow {
 public:
  ColorRow(QFormLayout* form, const std::function<void(std::array<int, 3>)>& change);

  void show(const ObjectRecord& object, const MirrorView& view) override;
  [[nodiscard]] bool isHeld() const override { return false; }

 private:
  QPushButton* button_;
  std::array<int, 3> shown_{};
};

/// The name, and the longest side of the box around the object, each done when Return is pressed or the field is left.
class NameAndSizeRow : public PropertyRow {
 public:
  NameAndSizeRow(QFormLayout* form, const std::function<void(const QString&)>& rename,
                 const std::function<void(double longest_m)>& scale);

  void show(const ObjectRecord& object, const MirrorView& view) override;
  [[nodiscard]] bool isHeld() const override;

 private:
  QLineEdit* name_;
  QDoubleSpinBox* size_;
  QString shownName_;
  ContentHash shownMesh_;
  double shown_mm_ = 0;
};

}  // namespace haptics

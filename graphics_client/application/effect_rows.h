#pragma once

#include <QObject>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "graphics_client/application/object_effects.h"
#include "graphics_client/application/property_rows.h"

class QListWidget;
class QSpinBox;
class QVBoxLayout;

namespace haptics {

/// The effects of an object: a list, from which one is chosen, and rows for the fields of that.
class EffectRows : public QObject, public PropertyRow {
 public:
  /// @param change    Is given what it changes, "effect 1 reach", and how.
  /// @param finished  As NumberRow's.
  /// @param made      Is given the rows of another effect.
  EffectRows(QFormLayout* form, std::function<void(const std::string&, SetProperty)> change,
             std::function<void()> finished, std::function<void(QWidget*)> made);

  void show(const ObjectRecord& object, const MirrorView& view) override;
  [[nodiscard]] bool isHeld() const override { return false; }
  /// Of the effect that is chosen; nothing: none is.
  [[nodiscard]] std::optional<HandleSpot> spot() const;

 protected:
  /// Delete removes the effect, not the object.
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  /// Of the effect that is chosen.
  struct Rows {
    EffectPlace place;
    std::size_t pathPoint = 0;
    std::vector<NumberProperty> numbers;
    std::vector<ChoiceProperty> choices;
    std::vector<std::unique_ptr<PropertyRow>> rows;  // of these
    std::unique_ptr<QWidget> widget;                 // which has theirs, and goes before them
  };

  std::function<void(const std::string&, SetProperty)> change_;
  std::function<void()> finished_;
  std::function<void(QWidget*)> made_;
  QListWidget* list_;
  QWidget* remove_;
  QVBoxLayout* below_;  // what is of the one that is chosen
  QWidget* path_;
  QSpinBox* pathPoint_;
  std::optional<std::pair<std::uint64_t, ObjectId>> of_;  // epoch and object that are shown
  std::vector<Effect::Kind> listed_;
  int rowBeforePress_ = -1;
  bool isAdding_ = false;  // the next that comes is chosen
  std::unique_ptr<Rows> rows_;

  [[nodiscard]] std::optional<EffectPlace> chosen() const;
  void edit(const std::string& what, const SetProperty& set);
  void add(Effect::Kind kind);
  void remove();
  void makeButtons(QFormLayout* form);
  void makePath();
  void list(const ObjectRecord& object);
  void makeRows(const EffectPlace& place, std::size_t pathPoint);
};

}  // namespace haptics

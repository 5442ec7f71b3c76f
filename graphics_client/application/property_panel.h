#pragma once

#include <QWidget>
#include <functional>
#include <memory>
#include <vector>

#include "common/scene/scene.h"
#include "haptics/v1/scene.pb.h"

class QFormLayout;
class QLabel;

namespace haptics {

/// The properties of one object, each with its unit and limits; an edit for each change, while it is dragged.
class PropertyPanel : public QWidget {
  Q_OBJECT

 public:
  PropertyPanel();

  /// What it shows: an object as the mirror has it, or none. A row that a person holds is left as it is.
  void show(const SceneVersion::Object& object, bool mayEdit);
  /// Beside the rows: what the server said of the last edit.
  void say(const QString& text, bool isError);

  /// One property of an object.
  class Row {
   public:
    virtual ~Row() = default;
    virtual void show(const ObjectRecord& object) = 0;
    [[nodiscard]] virtual bool isHeld() const = 0;
  };

 signals:
  /// @param property  "stiffness of torus".
  void edited(const QString& property, const haptics::v1::Transaction& change);
  /// The slider or field is let go of.
  void finished();

 private:
  QFormLayout* form_;
  QLabel* title_;
  QLabel* answer_;
  QWidget* rowsOf_;
  std::vector<std::unique_ptr<Row>> rows_;
  SceneVersion::Object shown_;

  void change(const QString& property, v1::Operation operation);
};

}  // namespace haptics

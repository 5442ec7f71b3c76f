#pragma once

#include <QThreadPool>
#include <QWidget>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "common/assets/asset_content.h"
#include "common/scene/scene.h"
#include "graphics_client/application/object_effects.h"
#include "graphics_client/application/property_rows.h"
#include "graphics_client/editing/edit_history.h"
#include "graphics_client/mirror/mirror_view.h"
#include "haptics/v1/scene.pb.h"

class QCheckBox;
class QFormLayout;
class QLabel;
class QScrollArea;

namespace haptics {

class EffectRows;
class TextureGallery;

/// The properties of one object, each with its unit and limits; an edit for each change, while it is dragged.
class PropertyPanel : public QWidget {
  Q_OBJECT

 public:
  PropertyPanel();

  /// What it shows: an object of the view, or none. A row that a person holds is left as it is.
  /// @param others   Names of objects that are changed with it.
  /// @param floor_m  World z: what is made to move comes to rest there.
  void show(const SceneVersion::Object& object, const std::set<std::string>& others,
            const std::shared_ptr<const MirrorView>& view, double floor_m);
  /// Below its name: what was advised on it; empty: nothing.
  void setAdvice(const QString& advice);
  /// Below the rows: what the server said of the last edit. After an error the rows show what holds.
  void say(const QString& text, bool isError);
  /// What handles in the picture move in place of the object: the effect that is chosen, or the joint; nothing: the object.
  [[nodiscard]] std::optional<HandleSpot> spot() const;
  /// A height map of the object that is shown, once it is read.
  void setImage(const QString& file);

 signals:
  /// @param property  "stiffness of torus".
  void edited(const QString& property, const haptics::Edit& change);
  /// The slider or field is let go of.
  void finished();
  void renamed(const QString& object, const QString& wanted);
  /// An edit with an asset that the server may not hold.
  void uploaded(const QString& edit, const haptics::Edit& change);

 protected:
  /// The wheel scrolls the panel, but for a number that has the focus. A key that moves a slider ends its edit. Space is the row's,
  /// undo and redo are the scene's.
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  QFormLayout* form_;
  QLabel* title_;
  QLabel* advice_;
  QLabel* answer_;
  QWidget* rowsOf_;
  QScrollArea* scroll_;  // of the rows
  std::vector<std::unique_ptr<PropertyRow>> rows_;
  TextureGallery* gallery_ = nullptr;  // one of the rows
  EffectRows* effects_ = nullptr;      // another
  QCheckBox* handlesOfJoint_;
  int fieldWidth_px_ = 0;
  SceneVersion::Object shown_;
  std::set<std::string> others_;            // that a change is made to as well
  std::shared_ptr<const MirrorView> view_;  // that has it
  double floor_m_ = 0;
  QThreadPool readers_;  // of images; waits for them when it goes

  void followEventsOf(QWidget* rows);
  void addTitle(const char* words);
  void addIdentity();
  void addRows(const PropertyGroup& group);
  void scale(double longest_m);
  void addGallery();
  void addEffects();
  void chooseImage();
  void takeImage(const std::string& object, const QString& file, const Result<AssetContent>& image);
  void showRows(bool withHeld);
  [[nodiscard]] std::set<std::string> names() const;
  void change(const QString& property, const SetProperty& set, bool othersMeet = false);
  void submit(const QString& property, const std::set<std::string>& names, const SetProperty& set, bool othersMeet);
};

}  // namespace haptics

#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/maths/vec.h"
#include "graphics_client/application/object_effects.h"
#include "graphics_client/application/scene_editor.h"
#include "graphics_client/viewer/scene_view.h"

class QMenu;
class QWidget;

namespace haptics {

/// Moves and turns the selected object, or a spot of it, by handles in the picture, and by steps. Each drag, and steps that follow each
/// other, are one edit. On the window's thread.
class GizmoTool {
 public:
  GizmoTool(SceneView& scene, SceneEditor& editor, std::function<std::shared_ptr<const MirrorView>()> newest)
      : scene_(scene), editor_(editor), newest_(std::move(newest)) {}

  /// What switches it, and steps. The keys of steps are those of the picture while it has the focus.
  void addActions(QMenu* menu, QWidget* picture);
  /// Before each frame.
  /// @param object  The selected one's name; empty: none.
  /// @param spot    Of it, that is moved in its place.
  /// @return  Whether the picture would be another one.
  bool update(const MirrorView& view, const std::string& object, const std::optional<HandleSpot>& spot,
              const std::optional<Pixel>& pointer);

  /// The left button goes down. True when that is on a handle, which is dragged from now on.
  bool press(const Pixel& pointer);
  [[nodiscard]] bool isDragging() const { return drag_.has_value(); }
  /// @return  Whether a handle was dragged.
  bool release();
  /// The steps until now are an edit of their own.
  void finishSteps();

 private:
  using Clock = std::chrono::steady_clock;

  SceneView& scene_;
  SceneEditor& editor_;
  std::function<std::shared_ptr<const MirrorView>()> newest_;
  bool isOn_ = false;
  std::string object_;              // empty: there is no gizmo
  std::optional<HandleSpot> spot_;  // of the object, as far as it is there
  GizmoPicture rest_;               // the gizmo where it is while it is not dragged
  std::optional<GizmoDrag> drag_;
  Pose begin_;  // what the drag or the steps began with
  struct Began {
    Pose pose;
    SpotState spot;
  };
  std::shared_ptr<std::optional<Began>>
      beganAt_;  // where the object was by then, which the picture may have shown later
  std::optional<Pixel> draggedTo_;
  std::optional<Pose> stepped_;  // where the steps have the object
  Clock::time_point lastStep_;
  std::optional<GizmoPicture> shown_;

  void step(Vec3 inPicture_m);
  void begin(const Pose& pose);
  void submit(const char* verb, const Pose& pose, bool turns);
  [[nodiscard]] Composer moving(Vec3 by_m, Quat turn, bool turns) const;
  [[nodiscard]] Composer movingSpot(Vec3 by_m, Quat turn) const;
  [[nodiscard]] std::optional<Pose> pose() const;
};

}  // namespace haptics

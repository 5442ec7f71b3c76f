#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "graphics_client/mirror/playback.h"
#include "graphics_client/viewer/camera_rig.h"
#include "graphics_client/viewer/contact_glyphs.h"
#include "graphics_client/viewer/effect_glyphs.h"
#include "graphics_client/viewer/gizmo_glyphs.h"
#include "graphics_client/viewer/overlay.h"
#include "graphics_client/viewer/render_window.h"
#include "graphics_client/viewer/run_summary.h"
#include "graphics_client/viewer/scene_actors.h"
#include "graphics_client/viewer/surface_probe.h"
#include "graphics_client/viewer/trail.h"

namespace haptics {

/// Draws what a client holds, frame by frame, with what was felt: objects, markers, close-up, overlay.
class SceneView {
 public:
  /// What one frame shows.
  struct FrameSnapshot {
    std::shared_ptr<const MirrorView> view;
    double age_s = 0;          ///< Of its sample.
    Trail trail, secondTrail;  ///< Of the hand, and of a second one.
  };
  /// What of it is drawn, and how.
  struct Style {
    bool follow = false, wireframe = false, edges = false, displacement = false;
    bool operator==(const Style&) const = default;
  };

  explicit SceneView(const ViewerOptions& options);

  /// A frame of the newest view, played back to now.
  /// @param now_s  Since the start of the run.
  void drawFrame(const std::shared_ptr<const MirrorView>& newest, double now_s);
  void setStyle(const Style& style);
  [[nodiscard]] const Style& style() const { return style_; }
  /// Objects of these names are not drawn.
  void hide(std::set<std::string> names) { objects_.hide(std::move(names)); }
  /// Shows all objects, seen along a direction as CameraRig::frame() takes it.
  void frameAll(Vec3 direction = CameraRig::kFirstDirection);
  /// The views that follow are of another source: nothing that came of those before is shown with them.
  void startAnew();

  [[nodiscard]] RenderWindow& renderWindow() { return renderWindow_; }
  [[nodiscard]] CameraRig& cameras() { return cameras_; }
  [[nodiscard]] Overlay& overlay() { return overlay_; }
  [[nodiscard]] const SceneActors& objects() const { return objects_; }
  [[nodiscard]] SurfaceProbe& probe() { return probe_; }
  /// Where the pointer is on the surface, and where it pulls the hand from; nothing: it leads no hand.
  void showPointer(const std::optional<SurfacePoint>& pointer) { pointer_ = pointer; }
  /// The objects of these names are marked.
  void select(std::set<std::string> names) { selected_ = std::move(names); }
  /// Places that are measured, joined by lines.
  void showMeasured(std::vector<Vec3> places) { measured_ = std::move(places); }
  /// As SceneActors has it.
  void cut(const std::optional<CutPlane>& plane) { objects_.cut(plane); }
  /// Nothing: none.
  void showGizmo(const std::optional<GizmoPicture>& gizmo) { gizmo_ = gizmo; }
  [[nodiscard]] RunSummary& summary() { return summary_; }
  /// The camera moved a moment ago: another frame is needed when it is over, with all that was left out meanwhile.
  [[nodiscard]] bool isMoving() const { return moving_; }
  [[nodiscard]] double framesPerSecond() const { return framesPerSecond_; }
  /// Drawn last.
  [[nodiscard]] const FrameSnapshot& snapshot() const { return snapshot_; }

  /// Shows the scene from there; also what comes first is not framed any more.
  void lookAs(const CameraRig::Look& look);
  /// A frame in which nothing is missing that is still being made; given in order of time.
  [[nodiscard]] vtkSmartPointer<vtkImageData> wholeFrame(const std::shared_ptr<const MirrorView>& view, double now_s);
  /// A picture of it with smooth outlines. `settle_s` lets the close-up's camera come to rest.
  [[nodiscard]] vtkSmartPointer<vtkImageData> picture(const FrameSnapshot& snapshot, double settle_s);
  /// The same with every surface as fine as it can be drawn.
  [[nodiscard]] vtkSmartPointer<vtkImageData> finePicture(const FrameSnapshot& snapshot);
  /// The scene alone, without words and close-up, this large.
  [[nodiscard]] vtkSmartPointer<vtkImageData> scenePicture(int width_px, int height_px);
  /// Without the overlay, whose text would be too small to be read.
  [[nodiscard]] vtkSmartPointer<vtkImageData> smallPicture();

 private:
  Playback playback_;
  RenderWindow renderWindow_;
  SceneActors objects_;
  SurfaceProbe probe_;
  /// Of a hand in both panes.
  struct HandGlyphs {
    ContactGlyphs scene, closeUp;
  };
  HandGlyphs glyphs_, secondGlyphs_;
  Glyph pointerGlyph_, pullGlyph_;
  Glyph selectionGlyph_, measureLines_, measurePoints_;
  EffectGlyphs effectGlyphs_;
  GizmoGlyphs gizmoGlyphs_;
  CameraRig cameras_;
  Overlay overlay_;
  RunSummary summary_;

  FrameSnapshot snapshot_;
  Style style_;
  std::optional<SurfacePoint> pointer_;
  std::optional<GizmoPicture> gizmo_;
  std::set<std::string> selected_;
  std::vector<Vec3> measured_;
  bool framed_ = false, wasLive_ = false, smooth_ = false;
  std::optional<std::uint64_t> stateResets_;  // nothing: of no view yet
  const std::size_t ledHand_;                 // by the pointer
  double resetAt_s_;
  CameraRig::Look look_;  // of the last frame
  double moved_s_ = 0;    // when the camera did
  bool moving_ = false, mayBeCoarse_ = true;
  double now_s_ = 0, rateFrom_s_ = 0, framesPerSecond_ = 0;
  std::uint64_t rateFrames_ = 0;

  void show(const FrameSnapshot& snapshot, double dt_s);
  void showPointer(const MirrorView& view, double metresPerPixel);
  void showSelection();
  void showMeasured();
  void noteChanges(const MirrorView& view);
  void adaptToCard();
  void followCamera();
  void showWhole(const std::function<void()>& draw);
};

}  // namespace haptics

#include "graphics_client/viewer/scene_view.h"

#include <vtkPolyData.h>

#include <algorithm>
#include <utility>

#include "common/clock/monotonic.h"
#include "graphics_client/viewer/poly_data.h"

namespace haptics {
namespace {

/// How long a server restart is told (seconds).
constexpr double kResetNotice_s = 6;
/// Frames a second are counted over this long (seconds).
constexpr double kRateWindow_s = 1;
/// Time in which the close-up's camera comes to rest (seconds).
constexpr double kSettled_s = 10;
/// Triangles for the textures of all objects together, half of which face away: what leaves software rendering on two
/// cores some 15 frames a second, and what a graphics card does or a picture is worth.
constexpr std::size_t kSoftwareTriangles = 150'000, kStillTriangles = 1'000'000;
/// Sizes in the close-up: larger markers, and arrows that stay inside it.
constexpr GlyphSizes kCloseUpSizes{.marker_px = 6, .arrow_mPerN = 0.0025, .arrowRadius_px = 2.8};
/// Of the arrow for which there is room above the objects, at most: stronger devices press with no more as a rule (newtons).
constexpr double kUsualForce_N = 3.3;
/// Radius of the pointer's mark and of the line from it to the hand.
constexpr double kPointer_px = 5, kPull_px = 1;
/// A camera that has not moved for so long is at rest (seconds).
constexpr double kRest_s = 0.15;
constexpr float kSelection_px = 2, kMeasured_px = 9;
/// Each edge of the box around the selected object is drawn this far from its ends.
constexpr double kBracketShare = 0.25;

}  // namespace

SceneView::SceneView(const ViewerOptions& options)
    : renderWindow_(options),
      objects_(renderWindow_.world().solid, renderWindow_.closeUp().solid),
      probe_(renderWindow_.world()),
      glyphs_{{renderWindow_.world(), GlyphSizes{}}, {renderWindow_.closeUp(), kCloseUpSizes}},
      secondGlyphs_{{renderWindow_.world(), GlyphSizes{}}, {renderWindow_.closeUp(), kCloseUpSizes}},
      pointerGlyph_(renderWindow_.world(), unitSphere(), Glyph::Kind::kAbove),
      pullGlyph_(renderWindow_.world(), unitCylinder(), Glyph::Kind::kAbove),
      selectionGlyph_(renderWindow_.world(), vtkNew<vtkPolyData>(), Glyph::Kind::kAbove),
      measureLines_(renderWindow_.world(), vtkNew<vtkPolyData>(), Glyph::Kind::kAbove),
      measurePoints_(renderWindow_.world(), vtkNew<vtkPolyData>(), Glyph::Kind::kAbove),
      effectGlyphs_(renderWindow_.world()),
      gizmoGlyphs_(renderWindow_.world()),
      cameras_(renderWindow_),
      overlay_(renderWindow_, !options.offscreen),
      ledHand_(options.hand),
      resetAt_s_(-kResetNotice_s) {
  pointerGlyph_.setVisible(false);
  pullGlyph_.setVisible(false);
  selectionGlyph_.setVisible(false);
  selectionGlyph_.setLineWidth(kSelection_px);
  measureLines_.setLineWidth(kSelection_px);
  measurePoints_.setLineWidth(kMeasured_px);
  setStyle({.displacement = options.displacement});
}

void SceneView::drawFrame(const std::shared_ptr<const MirrorView>& newest, double now_s) {
  const double dt_s = now_s - now_s_;
  now_s_ = now_s;
  const std::uint64_t now_ns = monotonicNow_ns();
  // Of a replay each moment is known.
  snapshot_.view = newest->isReplay ? newest : playback_.at(newest, now_ns);
  snapshot_.age_s = newest->isReplay ? 0 : newest->telemetryAgeAt_s(now_ns);
  noteChanges(*snapshot_.view);
  if (newest->sample) snapshot_.trail.add(*newest->sample, now_s_);
  if (newest->secondHand) snapshot_.secondTrail.add(*newest->secondHand, now_s_);
  show(snapshot_, dt_s);
  if (summary_.frames() == 0) adaptToCard();
  summary_.addFrame(newest, snapshot_.age_s, now_s_);
  summary_.addContact(*snapshot_.view);
  ++rateFrames_;
  if (now_s_ - rateFrom_s_ >= kRateWindow_s) {
    framesPerSecond_ = static_cast<double>(rateFrames_) / (now_s_ - rateFrom_s_);
    rateFrom_s_ = now_s_;
    rateFrames_ = 0;
  }
}

void SceneView::adaptToCard() {
  smooth_ = !renderWindow_.drawsInSoftware();
  renderWindow_.smoothOutlines(smooth_);
  objects_.setMaxTriangles(smooth_ ? kStillTriangles : kSoftwareTriangles);
  objects_.setVertexLighting(!smooth_);
}

void SceneView::setStyle(const Style& style) {
  cameras_.setFollow(style.follow);
  if (style.wireframe != style_.wireframe) objects_.setWireframe(style.wireframe);
  if (style.edges != style_.edges) objects_.setEdges(style.edges);
  if (style.displacement != style_.displacement) objects_.setDisplacement(style.displacement);
  style_ = style;
}

void SceneView::show(const FrameSnapshot& snapshot, double dt_s) {
  const MirrorView& view = *snapshot.view;
  const bool current = isCurrent(view, snapshot.age_s);
  if (objects_.update(view, current || !wasLive_)) {
    probe_.lookLast();
    for (HandGlyphs* glyphs : {&glyphs_, &secondGlyphs_}) {
      glyphs->scene.drawLast();
      glyphs->closeUp.drawLast();
    }
  }
  overlay_.update(view,
                  {.age_s = snapshot.age_s,
                   .framesPerSecond = framesPerSecond_,
                   .gridSpacing_m = objects_.gridSpacing_m(),
                   .closeUpMetresPerPixel = cameras_.closeUpMetresPerPixel(),
                   .friction = objects_.frictionRange(),
                   .coarse = objects_.coarsestDetail(),
                   .pitsFeltAsBumps = objects_.anyPitsFeltAsBumps(),
                   .wasLive = wasLive_,
                   .stateWasReset = now_s_ - resetAt_s_ < kResetNotice_s},
                  now_s_);
  if (!framed_ && view.link == LinkState::kLive && !objects_.isSettling() && !objects_.outline().empty()) {
    frameAll();
    framed_ = true;
  }
  cameras_.update(view.sample ? &*view.sample : nullptr, dt_s);
  overlay_.label(objects_.boxes());
  followCamera();
  objects_.showFor(cameras_.worldPosition(), cameras_.closeUpPosition());
  const double scale = view.sample ? cameras_.worldMetresPerPixel(view.sample->ihip) : 1;
  const auto showHand = [&](HandGlyphs& glyphs, const ShownHand& hand, const Trail& trail) {
    glyphs.scene.update(view, hand, trail, scale, current);
    glyphs.closeUp.update(view, hand, trail, cameras_.closeUpMetresPerPixel(), current);
  };
  showHand(glyphs_, {view.felt(0), view.maxForce_N, view.tool ? &*view.tool : nullptr}, snapshot.trail);
  showHand(secondGlyphs_, {view.felt(1), view.secondMaxForce_N, nullptr}, snapshot.secondTrail);
  showPointer(view, scale);
  showSelection();
  showMeasured();
  effectGlyphs_.update(view, current);
  gizmoGlyphs_.update(gizmo_, cameras_.picture());
  renderWindow_.render();
}

/// On a graphics card nothing is left out.
void SceneView::followCamera() {
  if (const CameraRig::Look look = cameras_.look(); std::exchange(look_, look) != look) {
    moved_s_ = now_s_;
    objects_.setCoarse(mayBeCoarse_ && !smooth_);
    moving_ = true;
  } else if (moving_ && now_s_ - moved_s_ > kRest_s) {
    moving_ = false;
    objects_.setCoarse(false);
    renderWindow_.settle();
  }
}

/// Also while the camera moves.
void SceneView::showWhole(const std::function<void()>& draw) {
  mayBeCoarse_ = false;
  objects_.setCoarse(false);
  draw();
  mayBeCoarse_ = true;
}

/// Stretched as the surface resists: the hand stays behind the pointer.
void SceneView::showPointer(const MirrorView& view, double metresPerPixel) {
  pointerGlyph_.setVisible(false);
  pullGlyph_.setVisible(false);
  const TelemetrySample* led = view.felt(ledHand_);
  if (!pointer_ || led == nullptr) return;
  const Vec3 from = pointer_->position, way = led->hip - from;
  pointerGlyph_.show(palette::kPointer,
                     alongAxis(from, {1, 0, 0}, kPointer_px * metresPerPixel, kPointer_px * metresPerPixel));
  const double length = glm::length(way);
  if (length > 0) {
    pullGlyph_.show(palette::kPointer, alongAxis(from, way / length, length, kPull_px * metresPerPixel));
  }
}

/// The corners of the box around each.
void SceneView::showSelection() {
  std::vector<Vec3> ends;
  for (const NamedBox& box : objects_.boxes()) {
    if (!selected_.contains(box.name)) continue;
    for (std::size_t from = 0; from < box.corners.size(); ++from) {
      for (const std::size_t axis : {1U, 2U, 4U}) {
        const Vec3 corner = box.corners[from];
        ends.insert(ends.end(), {corner, glm::mix(corner, box.corners[from ^ axis], kBracketShare)});
      }
    }
  }
  selectionGlyph_.setVisible(!ends.empty());
  if (ends.empty()) return;
  selectionGlyph_.setShape(segments(ends));
  selectionGlyph_.show(palette::kSelected, matrixOf({}));
}

void SceneView::showMeasured() {
  measureLines_.setVisible(false);
  measurePoints_.setVisible(false);
  if (measured_.empty()) return;
  measurePoints_.setShape(vertices(measured_));
  measurePoints_.show(palette::kMeasured, matrixOf({}));
  std::vector<Vec3> ends;
  for (std::size_t i = 1; i < measured_.size(); ++i) ends.insert(ends.end(), {measured_[i - 1], measured_[i]});
  if (ends.empty()) return;
  measureLines_.setShape(segments(ends));
  measureLines_.show(palette::kMeasured, matrixOf({}));
}

void SceneView::noteChanges(const MirrorView& view) {
  if (std::exchange(stateResets_, view.stateResets).value_or(view.stateResets) != view.stateResets) {
    resetAt_s_ = now_s_;
    snapshot_.trail.clear();
    snapshot_.secondTrail.clear();
    framed_ = false;
  }
  if (view.link == LinkState::kLive) wasLive_ = true;
}

void SceneView::startAnew() {
  stateResets_.reset();
  resetAt_s_ = -kResetNotice_s;
  snapshot_.trail.clear();
  snapshot_.secondTrail.clear();
  framed_ = wasLive_ = false;
}

/// The objects, and above them the arrow of the largest force.
void SceneView::frameAll(Vec3 direction) {
  std::vector<Vec3> points = objects_.outline();
  const double force_N = std::min(snapshot_.view ? snapshot_.view->maxForce_N : 0, kUsualForce_N);
  const double room_m = GlyphSizes{}.arrow_mPerN * force_N;
  const std::size_t count = points.size();
  for (std::size_t i = 0; i < count; ++i) points.push_back(points[i] + Vec3(0, 0, room_m));
  cameras_.frame(points, overlay_.freeAreas(), direction);
}

void SceneView::lookAs(const CameraRig::Look& look) {
  cameras_.lookAs(look);
  framed_ = true;
}

vtkSmartPointer<vtkImageData> SceneView::wholeFrame(const std::shared_ptr<const MirrorView>& view, double now_s) {
  objects_.settle(*view, true);
  showWhole([&] { drawFrame(view, now_s); });
  return renderWindow_.grab();
}

vtkSmartPointer<vtkImageData> SceneView::picture(const FrameSnapshot& snapshot, double settle_s) {
  renderWindow_.smoothOutlines(true);
  overlay_.refresh();
  showWhole([&] { show(snapshot, settle_s); });
  vtkSmartPointer<vtkImageData> picture = renderWindow_.grab();
  renderWindow_.smoothOutlines(smooth_);
  return picture;
}

vtkSmartPointer<vtkImageData> SceneView::finePicture(const FrameSnapshot& snapshot) {
  objects_.setMaxTriangles(kStillTriangles);
  objects_.setVertexLighting(false);
  objects_.settle(*snapshot.view, isCurrent(*snapshot.view, snapshot.age_s) || !wasLive_);
  vtkSmartPointer<vtkImageData> picture = this->picture(snapshot, kSettled_s);
  adaptToCard();
  return picture;
}

vtkSmartPointer<vtkImageData> SceneView::scenePicture(int width_px, int height_px) {
  const bool words = overlay_.isVisible(), closeUp = renderWindow_.closeUpShown();
  if (words) overlay_.toggle();
  renderWindow_.showCloseUp(false);
  const auto picture = renderWindow_.atSize(width_px, height_px, [this] { return finePicture(snapshot_); });
  renderWindow_.showCloseUp(closeUp);
  if (words) overlay_.toggle();
  return picture;
}

vtkSmartPointer<vtkImageData> SceneView::smallPicture() {
  overlay_.toggle();
  vtkSmartPointer<vtkImageData> small = picture(snapshot_, kSettled_s);
  overlay_.toggle();
  return small;
}

}  // namespace haptics

#include "graphics_client/viewer/viewer.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <functional>
#include <map>
#include <string>
#include <thread>

#include "common/clock/monotonic.h"
#include "graphics_client/mirror/playback.h"
#include "graphics_client/viewer/camera_rig.h"
#include "graphics_client/viewer/contact_glyphs.h"
#include "graphics_client/viewer/controls.h"
#include "graphics_client/viewer/overlay.h"
#include "graphics_client/viewer/picture_sheet.h"
#include "graphics_client/viewer/render_window.h"
#include "graphics_client/viewer/scene_actors.h"
#include "graphics_client/viewer/trail.h"

namespace haptics {
namespace {

/// How long a server restart is told (seconds).
constexpr double kResetNotice_s = 6;
/// Frames a second are counted over this long (seconds).
constexpr double kRateWindow_s = 1;
/// A contact that shows well: its force arrow is long enough to be seen (newtons).
constexpr double kShownForce_N = 1.0;
/// Time in which the close-up's camera comes to rest (seconds).
constexpr double kSettled_s = 10;
/// Triangles for the textures of all objects together, half of which face away: what leaves software rendering on two
/// cores some 15 frames a second, and what a graphics card does or a picture is worth.
constexpr std::size_t kSoftwareTriangles = 150'000, kStillTriangles = 1'000'000;
/// Sizes in the close-up: larger markers, and arrows that stay inside it.
constexpr GlyphSizes kCloseUpSizes{.marker_px = 6, .arrow_mPerN = 0.0025, .arrowRadius_px = 2.8};

class Viewer {
 public:
  Viewer(const ViewerOptions& options, const ViewSource& source);

  [[nodiscard]] Result<RunSummary> run(const std::atomic<bool>& stop);

 private:
  /// What one frame shows.
  struct FrameSnapshot {
    std::shared_ptr<const MirrorView> view;
    double age_s = 0;  ///< Of its sample.
    Trail trail;
  };

  ViewerOptions options_;
  ViewSource source_;
  Playback playback_;
  RenderWindow renderWindow_;
  SceneActors objects_;
  ContactGlyphs glyphs_, closeUpGlyphs_;
  CameraRig cameras_;
  Overlay overlay_;
  std::unique_ptr<Controls> controls_;
  RunSummary summary_;
  std::optional<PictureSheet> sheet_;

  FrameSnapshot snapshot_;             // drawn last
  std::optional<FrameSnapshot> best_;  // for the screenshot at the end
  bool quit_ = false, framed_ = false, wasLive_ = false, smooth_ = false;
  bool follow_ = false, wireframe_ = false, edges_ = false, displacement_ = false;
  int screenshots_ = 0;
  std::uint64_t stateResets_ = 0;
  double resetAt_s_ = -kResetNotice_s;
  double now_s_ = 0, rateFrom_s_ = 0, framesPerSecond_ = 0;
  std::uint64_t rateFrames_ = 0;

  [[nodiscard]] std::size_t maxTriangles() const { return smooth_ ? kStillTriangles : kSoftwareTriangles; }
  void drawFrame(double dt_s);
  void show(const FrameSnapshot& snapshot, double dt_s);
  void noteChanges(const MirrorView& view);
  [[nodiscard]] static int screenshotScore(const FrameSnapshot& snapshot);
  void handleKey(char key);
  void saveScreenshot();
  void frameAll(const MirrorView& view);
  void addToSheet();
  [[nodiscard]] vtkSmartPointer<vtkImageData> picture(const FrameSnapshot& snapshot, double settle_s);
};

Viewer::Viewer(const ViewerOptions& options, const ViewSource& source)
    : options_(options),
      source_(source),
      renderWindow_(options),
      objects_(renderWindow_.world().solid, renderWindow_.closeUp().solid),
      glyphs_(renderWindow_.world(), GlyphSizes{}),
      closeUpGlyphs_(renderWindow_.closeUp(), kCloseUpSizes),
      cameras_(renderWindow_),
      overlay_(renderWindow_, !options.offscreen) {
  objects_.setDisplacement(displacement_ = options.displacement);
  if (!options.sheet.empty() && options.duration_s) sheet_.emplace(*options.duration_s);
  if (options.offscreen) return;
  controls_ = std::make_unique<Controls>(
      renderWindow_.window(), renderWindow_.world().solid, [this](char key) { handleKey(key); },
      [this] { quit_ = true; });
}

Result<RunSummary> Viewer::run(const std::atomic<bool>& stop) {
  using Clock = std::chrono::steady_clock;
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / options_.frameLimit_Hz));
  const auto start = Clock::now();
  auto next = start;
  while (!quit_ && !stop) {
    const double before_s = now_s_;
    now_s_ = std::chrono::duration<double>(Clock::now() - start).count();
    if (options_.duration_s && now_s_ >= *options_.duration_s) break;
    if (controls_) controls_->process();
    drawFrame(now_s_ - before_s);
    next = std::max(next + period, Clock::now() - period);
    std::this_thread::sleep_until(next);
  }
  if (sheet_ && snapshot_.view) {
    if (sheet_->isEmpty()) addToSheet();
    const Result<void> written = sheet_->write(options_.sheet);
    if (!written) return tl::unexpected(written.error());
  }
  if (!options_.screenshot.empty() && snapshot_.view) {
    const FrameSnapshot& best = best_ ? *best_ : snapshot_;
    objects_.setMaxTriangles(kStillTriangles);
    objects_.setVertexLighting(false);
    objects_.settle(*best.view, isCurrent(*best.view, best.age_s) || !wasLive_);
    const Result<void> written = writePng(picture(best, kSettled_s), options_.screenshot);
    if (!written) return tl::unexpected(written.error());
  }
  return std::move(summary_);
}

void Viewer::drawFrame(double dt_s) {
  const auto newest = source_();
  const std::uint64_t now_ns = monotonicNow_ns();
  snapshot_.view = playback_.at(newest, now_ns);
  snapshot_.age_s = newest->telemetryAgeAt_s(now_ns);
  noteChanges(*snapshot_.view);
  if (newest->sample) snapshot_.trail.add(*newest->sample, now_s_);
  show(snapshot_, dt_s);
  if (summary_.frames() == 0) {
    smooth_ = !renderWindow_.drawsInSoftware();
    renderWindow_.smoothOutlines(smooth_);
    objects_.setMaxTriangles(maxTriangles());
    objects_.setVertexLighting(!smooth_);
  }
  summary_.addFrame(newest, snapshot_.age_s, now_s_);
  summary_.addContact(*snapshot_.view);
  ++rateFrames_;
  if (now_s_ - rateFrom_s_ >= kRateWindow_s) {
    framesPerSecond_ = static_cast<double>(rateFrames_) / (now_s_ - rateFrom_s_);
    rateFrom_s_ = now_s_;
    rateFrames_ = 0;
  }
  if (options_.offscreen && !options_.screenshot.empty() &&
      (!best_ || screenshotScore(snapshot_) >= screenshotScore(*best_))) {
    best_ = snapshot_;
  }
  if (sheet_ && sheet_->isDue(now_s_, screenshotScore(snapshot_) > 1)) addToSheet();
}

void Viewer::show(const FrameSnapshot& snapshot, double dt_s) {
  const MirrorView& view = *snapshot.view;
  const bool current = isCurrent(view, snapshot.age_s);
  if (objects_.update(view, current || !wasLive_)) {
    glyphs_.drawLast();
    closeUpGlyphs_.drawLast();
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
    frameAll(view);
    framed_ = true;
  }
  cameras_.update(view.sample ? &*view.sample : nullptr, dt_s);
  overlay_.label(objects_.boxes());
  objects_.showFor(cameras_.worldPosition(), cameras_.closeUpPosition());
  const double scale = view.sample ? cameras_.worldMetresPerPixel(view.sample->ihip) : 1;
  glyphs_.update(view, snapshot.trail, scale, current);
  closeUpGlyphs_.update(view, snapshot.trail, cameras_.closeUpMetresPerPixel(), current);
  renderWindow_.render();
}

void Viewer::noteChanges(const MirrorView& view) {
  if (view.stateResets != stateResets_) {
    stateResets_ = view.stateResets;
    resetAt_s_ = now_s_;
    snapshot_.trail.clear();
    framed_ = false;
  }
  if (view.link == LinkState::kLive) wasLive_ = true;
}

/// Nothing is seen, a contact, or a contact with a force worth seeing: 0, 1 or 2.
int Viewer::screenshotScore(const FrameSnapshot& snapshot) {
  const MirrorView& view = *snapshot.view;
  if (view.link != LinkState::kLive || !view.sample || view.sample->object == 0) return 0;
  return glm::length(view.sample->force.written) < kShownForce_N ? 1 : 2;
}

void Viewer::handleKey(char key) {
  const std::map<char, std::function<void()>> actions{
      {'r', [this] { frameAll(*snapshot_.view); }},
      {'f', [this] { cameras_.setFollow(follow_ = !follow_); }},
      {'c', [this] { renderWindow_.showCloseUp(!renderWindow_.closeUpShown()); }},
      {'w', [this] { objects_.setWireframe(wireframe_ = !wireframe_); }},
      {'e', [this] { objects_.setEdges(edges_ = !edges_); }},
      {'d', [this] { objects_.setDisplacement(displacement_ = !displacement_); }},
      {'n', [this] { overlay_.toggleLabels(); }},
      {'o', [this] { overlay_.toggle(); }},
      {'h', [this] { overlay_.toggleHelp(); }},
      {'s', [this] { saveScreenshot(); }},
      {'q', [this] { quit_ = true; }},
      {'\x1b', [this] { quit_ = true; }},
  };
  if (const auto action = actions.find(key); action != actions.end()) action->second();
}

void Viewer::saveScreenshot() {
  const std::filesystem::path file = "haptic_view_" + std::to_string(++screenshots_) + ".png";
  if (const Result<void> written = writePng(picture(snapshot_, 0), file); written) {
    spdlog::info("screenshot written to {}", file.string());
  } else {
    spdlog::error("{}", written.error().text());
  }
}

/// The objects, and above them the arrow of the largest force.
void Viewer::frameAll(const MirrorView& view) {
  std::vector<Vec3> points = objects_.outline();
  const double room_m = GlyphSizes{}.arrow_mPerN * view.maxForce_N;
  const std::size_t count = points.size();
  for (std::size_t i = 0; i < count; ++i) points.push_back(points[i] + Vec3(0, 0, room_m));
  cameras_.frame(points, overlay_.freeAreas());
}

/// Its text would be too small to be read there.
void Viewer::addToSheet() {
  overlay_.toggle();
  sheet_->add(picture(snapshot_, kSettled_s));
  overlay_.toggle();
}

vtkSmartPointer<vtkImageData> Viewer::picture(const FrameSnapshot& snapshot, double settle_s) {
  renderWindow_.smoothOutlines(true);
  overlay_.refresh();
  show(snapshot, settle_s);
  vtkSmartPointer<vtkImageData> picture = renderWindow_.grab();
  renderWindow_.smoothOutlines(smooth_);
  return picture;
}

}  // namespace

Result<RunSummary> runViewer(const ViewerOptions& options, const ViewSource& source, const std::atomic<bool>& stop) {
  return Viewer(options, source).run(stop);
}

}  // namespace haptics

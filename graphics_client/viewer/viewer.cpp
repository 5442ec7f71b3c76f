#include "graphics_client/viewer/viewer.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <string>
#include <thread>

#include "common/clock/monotonic.h"
#include "graphics_client/viewer/camera_rig.h"
#include "graphics_client/viewer/contact_glyphs.h"
#include "graphics_client/viewer/controls.h"
#include "graphics_client/viewer/overlay.h"
#include "graphics_client/viewer/scene_actors.h"
#include "graphics_client/viewer/stage.h"
#include "graphics_client/viewer/trail.h"

namespace haptics {
namespace {

/// How long a server restart is told (seconds).
constexpr double kResetNotice_s = 6;
/// Frames a second are counted over this long (seconds).
constexpr double kRateWindow_s = 1;
/// A picture kept for the screenshot at the end is replaced this often (seconds): reading it back costs milliseconds.
constexpr double kKeepEvery_s = 1;
/// A contact that shows well: its force arrow is long enough to be seen (newtons).
constexpr double kShownForce_N = 1.0;
/// Sizes in the close-up: larger markers, and arrows that stay inside it.
constexpr GlyphSizes kCloseUpSizes{.marker_px = 6, .arrow_mPerN = 0.0025, .arrowRadius_px = 2.8};

class Viewer {
 public:
  Viewer(const ViewerOptions& options, const ViewSource& source);

  [[nodiscard]] Result<RunSummary> run(const std::atomic<bool>& stop);

 private:
  ViewerOptions options_;
  ViewSource source_;
  Stage stage_;
  SceneActors objects_;
  ContactGlyphs glyphs_, closeUpGlyphs_;
  CameraRig cameras_;
  Overlay overlay_;
  std::unique_ptr<Controls> controls_;
  Trail trail_;
  RunSummary summary_;

  bool quit_ = false, framed_ = false, wasLive_ = false;
  bool follow_ = false, wireframe_ = false, edges_ = false;
  int screenshots_ = 0;
  std::uint64_t stateResets_ = 0;
  double resetAt_s_ = -kResetNotice_s;
  double now_s_ = 0, rateFrom_s_ = 0, framesPerSecond_ = 0;
  std::uint64_t rateFrames_ = 0;
  vtkSmartPointer<vtkImageData> kept_;
  bool keptShowsForce_ = false;
  double keptAt_s_ = -kKeepEvery_s;

  void drawFrame(double dt_s);
  void noteChanges(const MirrorView& view);
  void keepPicture(const MirrorView& view);
  void handleKey(char key);
  void saveScreenshot();
};

Viewer::Viewer(const ViewerOptions& options, const ViewSource& source)
    : options_(options),
      source_(source),
      stage_(options),
      objects_(stage_.world().solid, stage_.closeUp().solid),
      glyphs_(stage_.world(), GlyphSizes{}),
      closeUpGlyphs_(stage_.closeUp(), kCloseUpSizes),
      cameras_(stage_),
      overlay_(stage_, !options.offscreen) {
  if (options.offscreen) return;
  controls_ = std::make_unique<Controls>(
      stage_.window(), stage_.world().solid, [this](char key) { handleKey(key); }, [this] { quit_ = true; });
}

Result<RunSummary> Viewer::run(const std::atomic<bool>& stop) {
  using Clock = std::chrono::steady_clock;
  const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / options_.frameLimit_Hz));
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
  if (!options_.screenshot.empty()) {
    const Result<void> written = writePng(kept_ ? kept_ : stage_.grab(), options_.screenshot);
    if (!written) return tl::unexpected(written.error());
  }
  return std::move(summary_);
}

void Viewer::drawFrame(double dt_s) {
  const std::shared_ptr<const MirrorView> view = source_();
  const double age_s = view->telemetryAgeAt_s(monotonicNow_ns());
  const bool current = isCurrent(*view, age_s);
  noteChanges(*view);
  if (objects_.update(*view, current || !wasLive_)) {
    glyphs_.drawLast();
    closeUpGlyphs_.drawLast();
  }
  if (!framed_ && view->link == LinkState::kLive && !objects_.outline().empty()) {
    cameras_.frame(objects_.outline());
    framed_ = true;
  }
  if (view->sample) trail_.add(*view->sample, now_s_);
  cameras_.update(view->sample ? &*view->sample : nullptr, dt_s);
  objects_.setSeenFromAbove(cameras_.position());
  const double scale = view->sample ? cameras_.worldMetresPerPixel(view->sample->ihip) : 1;
  glyphs_.update(*view, trail_, scale, current);
  closeUpGlyphs_.update(*view, trail_, cameras_.closeUpMetresPerPixel(), current);
  overlay_.update(*view,
                  {.age_s = age_s,
                   .framesPerSecond = framesPerSecond_,
                   .gridSpacing_m = objects_.gridSpacing_m(),
                   .closeUpMetresPerPixel = cameras_.closeUpMetresPerPixel(),
                   .wasLive = wasLive_,
                   .stateWasReset = now_s_ - resetAt_s_ < kResetNotice_s},
                  now_s_);
  stage_.render();
  summary_.addFrame(view, age_s, now_s_);
  ++rateFrames_;
  if (now_s_ - rateFrom_s_ >= kRateWindow_s) {
    framesPerSecond_ = static_cast<double>(rateFrames_) / (now_s_ - rateFrom_s_);
    rateFrom_s_ = now_s_;
    rateFrames_ = 0;
  }
  keepPicture(*view);
}

void Viewer::noteChanges(const MirrorView& view) {
  if (view.stateResets != stateResets_) {
    stateResets_ = view.stateResets;
    resetAt_s_ = now_s_;
    trail_.clear();
    framed_ = false;
  }
  if (view.link == LinkState::kLive) wasLive_ = true;
}

void Viewer::keepPicture(const MirrorView& view) {
  if (options_.screenshot.empty() || !options_.offscreen) return;
  if (view.link != LinkState::kLive || !view.sample || view.sample->object == 0) return;
  const bool showsForce = glm::length(view.sample->force.written) >= kShownForce_N;
  if (keptShowsForce_ && !showsForce) return;
  if (now_s_ - keptAt_s_ < kKeepEvery_s && showsForce == keptShowsForce_) return;
  kept_ = stage_.grab();
  keptShowsForce_ = showsForce;
  keptAt_s_ = now_s_;
}

void Viewer::handleKey(char key) {
  switch (key) {
    case 'r': cameras_.frame(objects_.outline()); break;
    case 'f': cameras_.setFollow(follow_ = !follow_); break;
    case 'c': stage_.showCloseUp(!stage_.closeUpShown()); break;
    case 'w': objects_.setWireframe(wireframe_ = !wireframe_); break;
    case 'e': objects_.setEdges(edges_ = !edges_); break;
    case 'o': overlay_.toggle(); break;
    case 'h': overlay_.toggleHelp(); break;
    case 's': saveScreenshot(); break;
    case 'q':
    case '\x1b': quit_ = true; break;
    default: break;
  }
}

void Viewer::saveScreenshot() {
  const std::filesystem::path file = "haptic_view_" + std::to_string(++screenshots_) + ".png";
  const Result<void> written = writePng(stage_.grab(), file);
  if (written) {
    spdlog::info("screenshot written to {}", file.string());
  } else {
    spdlog::error("{}", written.error().text());
  }
}

}  // namespace

Result<RunSummary> runViewer(const ViewerOptions& options, const ViewSource& source, const std::atomic<bool>& stop) {
  return Viewer(options, source).run(stop);
}

}  // namespace haptics

#include "graphics_client/viewer/viewer.h"

#include <chrono>
#include <thread>

#include "graphics_client/viewer/picture_sheet.h"
#include "graphics_client/viewer/scene_view.h"

namespace haptics {
namespace {

/// A contact that shows well: its force arrow is long enough to be seen (newtons).
constexpr double kShownForce_N = 1.0;

/// Nothing is seen, a contact, or a contact with a force worth seeing: 0, 1 or 2.
int pictureScore(const SceneView::FrameSnapshot& snapshot) {
  const MirrorView& view = *snapshot.view;
  if (view.link != LinkState::kLive || !view.sample || view.sample->object == 0) return 0;
  return glm::length(view.sample->force.written) < kShownForce_N ? 1 : 2;
}

}  // namespace

Result<RunSummary> runOffscreen(const ViewerOptions& options, const ViewSource& source, const std::atomic<bool>& stop) {
  using Clock = std::chrono::steady_clock;
  SceneView scene(options);
  std::optional<PictureSheet> sheet;
  if (!options.sheet.empty() && options.duration_s) sheet.emplace(*options.duration_s);
  std::optional<SceneView::FrameSnapshot> best;  // for the screenshot at the end
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / options.frameLimit_Hz));
  const auto start = Clock::now();
  auto next = start;
  while (!stop) {
    const double now_s = std::chrono::duration<double>(Clock::now() - start).count();
    if (options.duration_s && now_s >= *options.duration_s) break;
    scene.drawFrame(source(), now_s);
    const int score = pictureScore(scene.snapshot());
    if (!options.screenshot.empty() && (!best || score >= pictureScore(*best))) best = scene.snapshot();
    if (sheet && sheet->isDue(now_s, score > 1)) sheet->add(scene.smallPicture());
    next = std::max(next + period, Clock::now() - period);
    std::this_thread::sleep_until(next);
  }
  const bool drewAny = scene.snapshot().view != nullptr;
  if (sheet && drewAny) {
    if (sheet->isEmpty()) sheet->add(scene.smallPicture());
    if (Result<void> written = sheet->write(options.sheet); !written) return tl::unexpected(written.error());
  }
  if (best) {
    if (Result<void> written = writePng(scene.finePicture(*best), options.screenshot); !written)
      return tl::unexpected(written.error());
  }
  return std::move(scene.summary());
}

}  // namespace haptics

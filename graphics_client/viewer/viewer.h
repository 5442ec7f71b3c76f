#pragma once

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "common/error/error.h"
#include "graphics_client/mirror/mirror_view.h"
#include "graphics_client/viewer/run_summary.h"

namespace haptics {

struct ViewerOptions {
  int width_px = 1280;
  int height_px = 1024;
  bool isSizeGiven = false;          ///< By the user; else a window fits the screen, and is as it was left.
  bool offscreen = false;            ///< No window; the picture goes to `screenshot`.
  std::optional<double> duration_s;  ///< Ends by itself after it.
  double frameLimit_Hz = 60;         ///< > 0.
  std::size_t hand = 0;              ///< That the pointer leads, below kMaxLedHands.
  bool displacement = false;         ///< Soft objects are coloured by how far they are displaced; the d key.
  std::filesystem::path
      sheet;  ///< Pictures of the run on one sheet, written at the end when not empty; needs a duration.
  std::filesystem::path screenshot;  ///< Written at the end when not empty.
};

/// The newest picture of the mirror; never null. Called once a frame, from the thread that runs the viewer.
using ViewSource = std::function<std::shared_ptr<const MirrorView>()>;

/// Why no window can be opened, in words for the user; nothing when the X display answers. To be asked before
/// a SceneView is made: VTK ends the process where there is none, offscreen too.
[[nodiscard]] Result<void> checkDisplay();

/// From here on the process ends with code 1 when the X server goes away, after `orderly`. Xlib and Qt would call exit(),
/// which destroys what threads that still run use.
/// @param orderly  Called on the thread that draws; draws nothing itself. Empty: nothing.
void onDisplayLost(std::function<void()> orderly);
[[noreturn]] void displayLost();  ///< Does so, for a library that does not ask Xlib's handler.

/// Draws what `source` gives, without a window, until the time is over or `stop` is set (by a signal handler). The
/// screenshot is the newest frame of a contact that shows well. Errors: a picture could not be written.
[[nodiscard]] Result<RunSummary> runOffscreen(const ViewerOptions& options, const ViewSource& source,
                                              const std::atomic<bool>& stop);

}  // namespace haptics

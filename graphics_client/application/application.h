#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "graphics_client/application/video_options.h"
#include "graphics_client/mirror/server_link.h"
#include "graphics_client/viewer/viewer.h"

namespace haptics {

/// The viewer in a window, until it is closed, the time is over, or `stop` is set (by a signal handler). Errors: the
/// screenshot could not be written.
/// @param link       Ends with the window: what it calls back is of the window's.
/// @param recording  File that is shown first, in place of the server; empty: none.
[[nodiscard]] Result<RunSummary> runApplication(const ViewerOptions& options, std::unique_ptr<ServerLink>& link,
                                                const ViewSource& source, const std::atomic<bool>& stop,
                                                const std::string& recording = {});

/// Makes a video of a recording, without a window; a part of it where `stop` is set meanwhile. Says how far it is.
/// Errors: the recording cannot be read, or the video not be written.
[[nodiscard]] Result<void> writeVideo(const std::string& recording, const VideoOptions& options,
                                      const std::atomic<bool>& stop);

}  // namespace haptics

#pragma once

#include <atomic>

#include "graphics_client/mirror/server_link.h"
#include "graphics_client/viewer/viewer.h"

namespace haptics {

/// The viewer in a window, until it is closed, the time is over, or `stop` is set (by a signal handler). Errors: the
/// screenshot could not be written.
[[nodiscard]] Result<RunSummary> runApplication(const ViewerOptions& options, ServerLink& link,
                                                const ViewSource& source, const std::atomic<bool>& stop);

}  // namespace haptics

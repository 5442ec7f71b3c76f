#pragma once

#include <filesystem>

#include "common/wire/endpoint.h"

namespace haptics::stress {

struct TouchViewerOptions {
  int number = 0;
  Endpoint server;
  bool datagrams = false;
  std::filesystem::path summary;
};

/// A viewer process that draws nothing: the link, playback and summary of graphics_client, sixty frames a second. Says on
/// standard output when it holds the scene; at SIGTERM writes its summary, and contact errors by the hand's speed.
void runTouchViewer(const TouchViewerOptions& options);

}  // namespace haptics::stress

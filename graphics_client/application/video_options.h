#pragma once

#include <filesystem>

namespace haptics {

/// Of a recording's video.
struct VideoOptions {
  std::filesystem::path file;
  int width_px = 1280, height_px = 800;
  double rate_Hz = 25;  ///< Pictures of a second.
};

}  // namespace haptics

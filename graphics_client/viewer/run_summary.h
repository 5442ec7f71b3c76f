#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/error/error.h"
#include "graphics_client/mirror/mirror_view.h"

namespace haptics {

/// The value that a share q (0 to 1) of the values does not exceed (nearest rank); 0 when there are none.
[[nodiscard]] double percentile(std::vector<double> values, double q);

/// What a viewer did in one run, for its summary file.
class RunSummary {
 public:
  /// Ages kept for the percentiles: the newest ones, half an hour at 60 frames a second.
  static constexpr std::size_t kAgesKept = 108'000;

  /// Once for each frame drawn. `time_s` counts from the start of the run.
  void addFrame(const MirrorView& view, double time_s);

  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }
  /// JSON object: viewer_frames, fps, client_scene_hash, scene_revision and hashes_equal (as they last stood while the
  /// link was live), telemetry_age_ms {p50, p99}, resyncs, state_resets.
  [[nodiscard]] std::string json() const;

 private:
  std::uint64_t frames_ = 0;
  double firstFrame_s_ = 0, lastFrame_s_ = 0;
  std::vector<double> ages_ms_;
  std::size_t oldestAge_ = 0;
  std::uint64_t lastSamples_ = 0;
  ContentHash sceneHash_;
  std::uint64_t sceneRevision_ = 0;
  bool hashesEqual_ = false;
  std::uint64_t resyncs_ = 0, stateResets_ = 0;
};

/// Writes `text` to the file, whole or not at all. Errors name the file.
[[nodiscard]] Result<void> writeFile(const std::filesystem::path& file, const std::string& text);

}  // namespace haptics

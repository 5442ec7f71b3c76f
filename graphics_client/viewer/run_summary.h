#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/error/error.h"
#include "graphics_client/mirror/contact_error.h"
#include "graphics_client/mirror/mirror_view.h"

namespace haptics {

/// The value that a share q (0 to 1) of the values does not exceed (nearest rank); 0 when there are none.
[[nodiscard]] double percentile(std::vector<double> values, double q);

/// What a viewer did in one run, for its summary file.
class RunSummary {
 public:
  /// Ages kept for the percentiles: the newest ones, half an hour at 60 frames a second.
  static constexpr std::size_t kAgesKept = 108'000;

  /// Once for each frame drawn. `view` is not null, `age_s` is the age of its sample when drawn; `time_s` counts from
  /// the start of the run.
  void addFrame(std::shared_ptr<const MirrorView> view, double age_s, double time_s);

  /// How far the IHIP that was drawn is from the surface that was drawn (m), where something that moves or yields is touched;
  /// noted, and returned.
  std::optional<double> addContact(const MirrorView& shown);

  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }
  [[nodiscard]] bool wasConnected() const noexcept { return newestLive_ != nullptr; }
  /// JSON object: viewer_frames, fps, telemetry_age_ms {p50, p99}, contact_error_mm {p50, p99}, resyncs, state_resets and, as they last stood while
  /// the link was live, scene_revision, client_scene_hash (computed anew from every byte that this client holds, empty
  /// while a mesh is missing) and hashes_equal.
  [[nodiscard]] std::string json() const;

 private:
  std::uint64_t frames_ = 0;
  double firstFrame_s_ = 0, lastFrame_s_ = 0;
  /// The newest kAgesKept of many values.
  struct Newest {
    std::deque<double> values;
    void add(double value);
  };
  Newest ages_ms_, contactErrors_mm_;
  ContactError contactError_;
  std::shared_ptr<const MirrorView> newest_, newestLive_;
};

}  // namespace haptics

#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "common/error/error.h"
#include "graphics_client/mirror/mirror_view.h"
#include "graphics_client/session/recorded_moments.h"
#include "haptic_server/recording/replay.h"

namespace haptics {

/// A recording that was run again, as a window shows it.
class RecordedSession {
 public:
  /// Of an edit that the servo adopted, a fault, or a button that marks.
  struct Mark {
    double time_s;
    bool isFault;
    std::string text;
  };
  static constexpr std::size_t kMaxMarks = 10'000;  ///< Those beyond are left out.
  /// Of all scenes together. Where they would be more, the session ends before the scene.
  static constexpr std::size_t kMaxScenes_bytes = std::size_t{2} << 30;

  /// Runs the step over the whole file. Refused, naming the file: it cannot be read, is no recording, or has no tick
  /// that could be run.
  /// @param stop      Refused with "cancelled" soon after it says so.
  /// @param progress  Gets the share of the file that is done, for each tick.
  [[nodiscard]] static Result<RecordedSession> read(const std::filesystem::path& file, const std::stop_token& stop,
                                                    const std::function<void(double share)>& progress = {});

  [[nodiscard]] const std::string& name() const noexcept { return name_; }  ///< Of the file, without its folder.
  [[nodiscard]] double duration_s() const noexcept { return moments_.list().back().time_s; }
  [[nodiscard]] const RecordedMoments& moments() const noexcept { return moments_; }
  [[nodiscard]] const std::vector<Mark>& marks() const noexcept { return marks_; }
  [[nodiscard]] const ReplayOutcome& outcome() const noexcept { return outcome_; }
  /// Whether the forces are those of the recording, for people: "every force is the same bit for bit".
  [[nodiscard]] std::string verdict() const;
  /// What is kept of the ticks, for people.
  [[nodiscard]] std::string extent() const;
  /// "replay of FILE, 3.20 s of 10.00 s; every force is the same bit for bit".
  [[nodiscard]] std::string status(double time_s) const;

  /// A moment as a live view of a server would show it.
  /// @param now_ns  This host's monotonic clock.
  [[nodiscard]] std::shared_ptr<const MirrorView> view(std::size_t moment, std::uint64_t now_ns) const;

 private:
  class Reader;
  std::string name_;
  ReplayOutcome outcome_;
  std::string endedEarly_;  // why; empty: it did not
  RecordedMoments moments_;
  std::vector<Mark> marks_;
  std::vector<std::shared_ptr<const MirrorView>> scenes_;
};

}  // namespace haptics

#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace haptics {

/// Where a replay stands on its time line (seconds).
class ReplayClock {
 public:
  static constexpr std::array kSpeeds{0.1, 0.5, 1.0};  ///< Of the recorded one.

  explicit ReplayClock(double duration_s = 0) : duration_s_(duration_s) {}

  [[nodiscard]] double duration_s() const noexcept { return duration_s_; }
  [[nodiscard]] double time_s() const noexcept { return time_s_; }
  [[nodiscard]] bool isPlaying() const noexcept { return playing_; }
  [[nodiscard]] std::size_t speed() const noexcept { return speed_; }

  /// From the end it plays from the beginning.
  void setPlaying(bool playing) noexcept {
    if (playing && time_s_ >= duration_s_) time_s_ = 0;
    playing_ = playing;
  }
  /// @param index  Of kSpeeds; clamped.
  void setSpeed(std::size_t index) noexcept { speed_ = std::min(index, kSpeeds.size() - 1); }
  /// Clamped to the recording.
  void seek(double time_s) noexcept { time_s_ = std::clamp(time_s, 0.0, duration_s_); }
  /// So much time has passed for the person who looks on. Stops at the end.
  void advance(double dt_s) noexcept {
    if (!playing_) return;
    seek(time_s_ + std::max(0.0, dt_s) * kSpeeds[speed_]);
    if (time_s_ >= duration_s_) playing_ = false;
  }

 private:
  double duration_s_;
  double time_s_ = 0;
  bool playing_ = false;
  std::size_t speed_ = kSpeeds.size() - 1;
};

}  // namespace haptics

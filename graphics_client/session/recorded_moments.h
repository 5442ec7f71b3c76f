#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/telemetry/motion_state.h"
#include "common/telemetry/telemetry_sample.h"

namespace haptics {

/// Where the objects that move or yield were.
struct RecordedMotion {
  std::vector<BodyState> bodies;
  std::vector<ObjectDent> dents;
  ToolState tool;
};

/// What a recording shows of one tick.
struct RecordedMoment {
  double time_s = 0;  ///< Since the recording's first tick.
  TelemetrySample sample;
  std::shared_ptr<const RecordedMotion> motion;  ///< Null: nothing moves.
  std::size_t scene = 0;                         ///< Index of its scene.
  std::optional<TelemetrySample> secondHand{};   ///< Where there is one.
};

/// Moments of a recording at display rate, within a bound of memory: where they would pass it, every other one is
/// dropped, and those that follow come half as often.
class RecordedMoments {
 public:
  static constexpr double kInterval_s = 1.0 / 250;                  ///< Between moments that are kept, at first.
  static constexpr std::size_t kMaxBytes = std::size_t{256} << 20;  ///< Some 20 minutes at that rate.

  explicit RecordedMoments(std::size_t maxBytes = kMaxBytes) : maxBytes_(maxBytes) {}

  /// Whether a moment of this time is kept. In order of time.
  [[nodiscard]] bool wants(double time_s) const;
  /// @param moment  After those before.
  void add(RecordedMoment moment);

  [[nodiscard]] const std::vector<RecordedMoment>& list() const noexcept { return list_; }
  [[nodiscard]] double interval_s() const noexcept { return interval_s_; }
  /// Of the last moment at this time or before; the first one before that. There is at least one.
  [[nodiscard]] std::size_t indexAt(double time_s) const;

 private:
  std::size_t maxBytes_;
  double interval_s_ = kInterval_s;
  std::size_t bytes_ = 0;
  std::vector<RecordedMoment> list_;

  [[nodiscard]] std::size_t bytesOf(std::size_t index) const;
  void thinOut();
};

}  // namespace haptics

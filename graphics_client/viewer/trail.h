#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>

#include "common/telemetry/telemetry_sample.h"

namespace haptics {

/// Where the IHIP touched in the last second, newest last. World frame.
class Trail {
 public:
  static constexpr double kLength_s = 1;

  struct Point {
    Vec3 place;
    double time_s;
    bool startsStroke;  ///< Not joined with the point before it.
  };

  /// `time_s` on the viewer's clock, not falling.
  void add(const TelemetrySample& sample, double time_s) {
    now_s_ = time_s;
    while (!points_.empty() && points_.front().time_s < time_s - kLength_s) points_.pop_front();
    if (sample.tick == lastTick_) return;
    lastTick_ = sample.tick;
    if (sample.object != 0) points_.push_back({sample.ihip, time_s, sample.object != lastObject_});
    lastObject_ = sample.object;
  }
  void clear() { points_.clear(); }

  [[nodiscard]] const std::deque<Point>& points() const { return points_; }
  /// 1 now, 0 when about to vanish.
  [[nodiscard]] double freshness(const Point& point) const {
    return std::clamp(1 - (now_s_ - point.time_s) / kLength_s, 0.0, 1.0);
  }

 private:
  std::deque<Point> points_;
  std::uint64_t lastTick_ = 0, lastObject_ = 0;
  double now_s_ = 0;
};

}  // namespace haptics

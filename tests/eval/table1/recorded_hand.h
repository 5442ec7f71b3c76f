#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "haptic_server/device/device.h"
#include "tests/eval/table1/paper_objects.h"

namespace haptics::eval {

/// A device that plays a recording, a place to the tick, again and again, and feels nothing.
class RecordedHand final : public Device {
 public:
  static constexpr double kStep_m = 1e-4;  ///< Of the HIP in a tick: 0.1 m/s at 1 kHz.

  /// Any thread. Lifts off and waits above the surface, or begins anew: an object that is exchanged under the hand could
  /// leave the IHIP in its inside.
  void setAway(bool away) noexcept { away_.store(away, std::memory_order_relaxed); }

  /// Presses, goes eight times round the circle of paper_objects.h, lifts.
  RecordedHand();
  [[nodiscard]] const std::vector<Vec3>& places() const noexcept { return places_; }

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] DeviceReading read(std::uint64_t tick) noexcept override {
    if (away_.load(std::memory_order_relaxed)) began_ = tick;
    return {places_[(tick - began_) % places_.size()], DeviceState::kReady};
  }
  void write(Vec3 force_N) noexcept override { held_ = force_N; }
  void stop() noexcept override { held_ = Vec3(0); }

 private:
  DeviceInfo info_{"recording", 3.3, 1000, 5, 0};
  std::vector<Vec3> places_;
  Vec3 held_{0};
  std::atomic<bool> away_{false};
  std::uint64_t began_ = 0;
};

}  // namespace haptics::eval

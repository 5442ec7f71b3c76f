#pragma once

#include <algorithm>
#include <cstdint>

#include "common/maths/vec.h"

// What stands between the force law and the device, in this order: finite check (the step's, it names the fault),
// blend, magnitude limit. There is no slew limit: at 0.3 N a tick it turned a stable tap into an unstable one.
namespace haptics {

/// Blends out the jump that an edit, attach or re-seat causes.
class ForceBlend {
 public:
  /// Seconds over which the jump fades. Shorter is more of a kick, longer leaves a wrong force standing.
  static constexpr double kDuration_s = 0.05;

  /// The force was `before` and would now be `after`; a jump that still fades is taken over, since `before` holds it.
  void begin(Vec3 before, Vec3 after) noexcept {
    jump_ = before - after;
    remaining_s_ = kDuration_s;
  }

  /// Whether there is still a jump to fade.
  [[nodiscard]] bool active() const noexcept { return remaining_s_ > 0; }

  /// This tick's force; begins at `before`, ends at `force`.
  [[nodiscard]] Vec3 apply(Vec3 force, double period_s) noexcept {
    if (remaining_s_ <= 0) return force;
    const Vec3 blended = force + jump_ * (remaining_s_ / kDuration_s);
    remaining_s_ -= period_s;
    return blended;
  }

 private:
  Vec3 jump_{0};
  double remaining_s_ = 0;
};

/// The force shortened to at most `limit_N`, its direction kept.
[[nodiscard]] inline Vec3 limitMagnitude(Vec3 force, double limit_N) noexcept {
  const double squared = glm::dot(force, force);
  return squared > limit_N * limit_N ? force * (limit_N / std::sqrt(squared)) : force;
}

/// The part of a force (N) that was written: 1 unless it was limited, or is being ramped.
[[nodiscard]] inline double partWritten(Vec3 written, Vec3 unlimited) noexcept {
  if (written == unlimited) return 1;
  const double squared = glm::dot(unlimited, unlimited);
  return squared > 0 ? glm::dot(written, unlimited) / squared : 0;
}

/// Takes the force away within kDuration_s once something is wrong, and keeps it away until begin().
class FaultRamp {
 public:
  /// With the 5 ms in which a device that is gone is noticed, the force is zero within 30 ms of the pull. Shorter is more of
  /// a kick where only a few positions came late.
  static constexpr double kDuration_s = 0.02;

  /// The force comes within so many seconds; 0: at once.
  void begin(double rise_s) noexcept {
    rise_s_ = rise_s;
    gain_ = rise_s > 0 ? 0 : 1;
  }

  [[nodiscard]] Vec3 apply(bool faulty, Vec3 force, double period_s) noexcept {
    if (faulty) {
      gain_ = std::max(0.0, gain_ - period_s / kDuration_s);
    } else if (gain_ < 1) {
      gain_ = std::min(1.0, gain_ + period_s / rise_s_);
    }
    return force * gain_;
  }
  [[nodiscard]] bool atZero() const noexcept { return gain_ <= 0; }
  [[nodiscard]] bool atOne() const noexcept { return gain_ >= 1; }

 private:
  double gain_ = 1;
  double rise_s_ = 0;
};

/// Counts ticks that never came.
class DeadlineWatch {
 public:
  /// Seconds of missed ticks, with none on time between them, after which the force that stood meanwhile is taken away.
  /// Shorter faults a server without real-time priority on a busy machine; in longer ones a light device gets far.
  static constexpr double kMost_s = 0.05;

  /// Ticks missed since the last one. A lower number than the last is a new count.
  [[nodiscard]] std::uint64_t missed(std::uint64_t tick) noexcept {
    const std::uint64_t missed = tick > last_ + 1 && last_ != kNone ? tick - last_ - 1 : 0;
    inARow_ = missed > 0 ? inARow_ + missed : 0;
    last_ = tick;
    return missed;
  }
  [[nodiscard]] bool tooMany(double period_s) const noexcept {
    return static_cast<double>(inARow_) * period_s >= kMost_s;
  }

 private:
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};
  std::uint64_t last_ = kNone;
  std::uint64_t inARow_ = 0;
};

}  // namespace haptics

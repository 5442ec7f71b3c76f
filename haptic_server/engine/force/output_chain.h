#pragma once

#include <algorithm>
#include <cstdint>

#include "common/maths/vec.h"
#include "haptic_server/engine/force/spring_damper.h"

// What stands between the force law and the device, in this order: finite check (the step's, it names the fault), slew
// limit of an edit, magnitude limit.
namespace haptics {

/// Bounds how fast an edit changes the force, or an IHIP that was put out of a body. While it is active the force is what is
/// felt and a rest of what was felt before:
///   F = F_felt + R,  |dR/dt| <= r.
/// Of the change of F_felt in a tick, so much is the hand's own and goes through at once:
///   2 (K T + B) dx / T,
/// K and B the stiffness and damping that are felt, T the period, dx the way of the HIP: twice what a plane makes of it, so
/// that contact stays what it is, and nothing of it while device and surface stand still: an observer's HIP answers to the
/// force. What is more is taken into R, which then lets it in at the rate r; with both at rest that is everything. No general
/// slew limit, which at 0.3 N a tick turned a stable tap into an unstable one.
class EditSlew {
 public:
  static constexpr double kRate_N_per_s = RateLimitedStiffness::kRate_N_per_s;  ///< r
  /// Active for so long after the last tick in which an edit did something. Shorter misses what a surface does late; longer
  /// takes jumps for the edit's that are the hand's.
  static constexpr double kSettled_s = 0.1;
  /// In which the way of the hand in a tick counts for 1/e of itself: a slow hand shows as single steps of the encoder.
  static constexpr double kMemory_s = 5e-3;
  /// Without a step of the encoder for so long, the hand rests. A hand that is slower changes the force by less than r.
  static constexpr double kResting_s = 20e-3;

  /// An edit changes the force, from the next follow() on.
  void begin() noexcept {
    fresh_ = fresh_ || !active();
    remaining_s_ = kSettled_s;
  }
  [[nodiscard]] bool active() const noexcept { return remaining_s_ > 0; }
  /// The next follow() goes on from a rest that there is.
  [[nodiscard]] bool goesOn() const noexcept { return active() && !fresh_; }
  /// Of the last follow(): the part of the change that the rest has taken, and the part of the rest that was left then.
  [[nodiscard]] double taken() const noexcept { return taken_; }
  [[nodiscard]] double left() const noexcept { return left_; }

  /// @param before  The force of the last tick, N.
  /// @param felt  What is felt in this one, N.
  /// @param measured, hip  Where the device is, and where the force was computed; world, m.
  /// @param carried_m  Way of the surface by itself in this tick.
  /// @param k  Of the surface; none while none is touched: then that of the last one.
  /// @param jumps  The edit changes it at once: nothing of the change is the hand's own.
  /// @param byTime_N  So much of the change is of the time alone, and no edit's either.
  [[nodiscard]] Vec3 follow(Vec3 before, Vec3 felt, Vec3 measured, Vec3 hip, double carried_m, Stiffness k, bool jumps,
                            double period_s, double byTime_N = 0) noexcept {
    if (fresh_) {
      felt_N_ = before;
      rest_N_ = Vec3(0);
      measured_ = measured;
      hip_ = hip;
      way_m_ = 0;
      resting_s_ = kResting_s;
      fresh_ = false;
    }
    resting_s_ = measured == measured_ ? resting_s_ + period_s : 0;
    measured_ = measured;
    way_m_ = std::max(glm::distance(hip, hip_) + carried_m, way_m_ * (1 - std::min(1.0, period_s / kMemory_s)));
    if (k.spring_N_per_m > 0) k_ = k;
    const bool nothing = jumps || (resting_s_ >= kResting_s && carried_m == 0);
    const double own_N =
        (nothing ? 0 : 2 * (k_.spring_N_per_m + k_.damping_Ns_per_m / period_s) * way_m_) + (jumps ? 0 : byTime_N);
    const Vec3 change_N = felt - felt_N_;
    felt_N_ = felt;
    hip_ = hip;
    remaining_s_ -= period_s;
    const double length_N = glm::length(change_N);
    taken_ = length_N > own_N ? 1 - own_N / length_N : 0;
    if (taken_ > 0) {
      rest_N_ -= change_N * taken_;
      remaining_s_ = kSettled_s;
    }
    const double rest_N = glm::length(rest_N_);
    const double let_N = kRate_N_per_s * period_s;
    if (rest_N > let_N) remaining_s_ = kSettled_s;
    left_ = rest_N > let_N ? 1 - let_N / rest_N : 0;
    rest_N_ = left_ > 0 ? rest_N_ * left_ : Vec3(0);
    return felt + rest_N_;
  }

  HAPTICS_FIELDS(self.fresh_, self.remaining_s_, self.felt_N_, self.rest_N_, self.measured_, self.hip_, self.resting_s_,
                 self.way_m_, self.k_, self.taken_, self.left_);

 private:
  Word<bool> fresh_ = false;
  double remaining_s_ = 0;
  Vec3 felt_N_{0};    // in the last tick
  Vec3 rest_N_{0};    // R
  Vec3 measured_{0};  // likewise
  Vec3 hip_{0};       // likewise
  double resting_s_ = 0;
  double way_m_ = 0;
  Stiffness k_;
  double taken_ = 0, left_ = 0;
};

/// The force shortened to at most `limit_N`, its direction kept.
[[nodiscard]] inline Vec3 limitMagnitude(Vec3 force, double limit_N) noexcept {
  const double squared = glm::dot(force, force);
  return squared > limit_N * limit_N ? force * (limit_N / std::sqrt(squared)) : force;
}

/// The part of a force (N) that was written: 1 unless it was limited, or is being ramped.
[[nodiscard]] inline double writtenFraction(Vec3 written, Vec3 unlimited) noexcept {
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
  [[nodiscard]] double gain() const noexcept { return gain_; }
  [[nodiscard]] bool atZero() const noexcept { return gain_ <= 0; }
  [[nodiscard]] bool atOne() const noexcept { return gain_ >= 1; }

  HAPTICS_FIELDS(self.gain_, self.rise_s_);

 private:
  double gain_ = 1;
  double rise_s_ = 0;
};

/// Counts ticks that never came, and says for how long the force stays away once they were too many. A force that is taken
/// away and comes back again and again shakes the hand: from the second time within kFlaps_s of its return on it stays away
/// for kFirstWait_s, then twice as long each time, up to kLongestWait_s.
class DeadlineWatch {
 public:
  static constexpr double kFlaps_s = 2;
  static constexpr double kFirstWait_s = 2;
  static constexpr double kLongestWait_s = 30;

  /// Seconds of missed ticks, with none on time between them, after which the force that stood meanwhile is taken away.
  /// Shorter faults a server without real-time priority on a busy machine; in longer ones a light device gets far.
  static constexpr double kMax_s = 0.05;

  /// Ticks missed since the last one. A lower number than the last is a new count.
  [[nodiscard]] std::uint64_t missed(std::uint64_t tick) noexcept {
    if (tick == last_ + 1) [[likely]] {  // kNone + 1 is 0
      last_ = tick;
      inARow_ = 0;
      return 0;
    }
    const std::uint64_t missed = tick > last_ + 1 && last_ != kNone ? tick - last_ - 1 : 0;
    inARow_ = missed > 0 ? inARow_ + missed : 0;
    if (tick < last_) returns_ = 0;
    last_ = tick;
    return missed;
  }
  /// They were too many.
  void giveUp(std::uint64_t tick, double period_s) noexcept {
    const bool flaps = returns_ != 0 && static_cast<double>(tick - returns_) * period_s < kFlaps_s;
    wait_s_ = flaps ? std::min(kLongestWait_s, std::max(kFirstWait_s, 2 * wait_s_)) : 0;  // also of NaN
    returns_ = tick + static_cast<std::uint64_t>(wait_s_ / period_s);
  }
  /// Until the force may come back; 0 when it may.
  [[nodiscard]] double wait_s(std::uint64_t tick, double period_s) const noexcept {
    return tick < returns_ ? static_cast<double>(returns_ - tick) * period_s : 0;
  }
  [[nodiscard]] bool tooMany(double period_s) const noexcept {
    return static_cast<double>(inARow_) * period_s >= kMax_s;
  }

  HAPTICS_FIELDS(self.last_, self.inARow_, self.returns_, self.wait_s_);

 private:
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};
  std::uint64_t last_ = kNone;
  std::uint64_t inARow_ = 0;
  std::uint64_t returns_ = 0;  // the tick from which the force may come back; 0: it never was away
  double wait_s_ = 0;          // the last time
};

}  // namespace haptics

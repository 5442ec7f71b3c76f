#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <random>
#include <string_view>

#include "common/maths/vec.h"
#include "haptic_server/device/plant.h"

namespace haptics::test {

/// What may be wrong with a device.
enum class Defect {
  kNone,
  kXStandsStill,
  kAllStandStill,
  kValuesAt60Hz,     ///< New positions come at 1 kHz, with old values.
  kPositionsAt60Hz,  ///< As is.
  kPositionsAt500Hz,
  kSpikes,  ///< One position now and then is off.
  kJump,    ///< From some time on all are off.
  kNoise,
  kOldPositions,
  kReversedZ,
  kXForY,
  kNoForce,
  kLateForce,
  kNoWatchdog,
  kSlowWatchdog,
  kStifferSaidThanBorne,
  kForceEndsSlowly
};
inline constexpr std::array<std::string_view, 18> kDefects{"none",
                                                           "x_stands_still",
                                                           "all_stand_still",
                                                           "values_at_60_hz",
                                                           "positions_at_60_hz",
                                                           "positions_at_500_hz",
                                                           "spikes",
                                                           "jump",
                                                           "noise",
                                                           "old_positions",
                                                           "reversed_z",
                                                           "x_for_y",
                                                           "no_force",
                                                           "late_force",
                                                           "no_watchdog",
                                                           "slow_watchdog",
                                                           "stiffer_said_than_borne",
                                                           "force_ends_slowly"};

/// An arm with a defect in a hand that moves it about for some seconds, and then holds it lightly in the middle. The seed draws hand,
/// motion and how large the defect is. Times are ns of one clock.
class DefectiveArm {
 public:
  static constexpr double kMaxForce_N = 5, kResolution_m = 1e-5, kDelay_s = 0.001;

  DefectiveArm(Defect defect, unsigned seed, double moves_s);

  struct Position {
    Vec3 position{0};
    std::uint64_t measured_ns = 0;
    std::uint64_t count = 0;  ///< Of new positions up to this one.
  };
  [[nodiscard]] const Position& read(std::uint64_t now_ns);
  void write(Vec3 force_N, std::uint64_t now_ns);
  [[nodiscard]] double saidStiffness_N_per_m() const { return defect_ == Defect::kStifferSaidThanBorne ? 8'000 : 300; }

 private:
  struct Written {
    std::uint64_t from_ns;
    Vec3 force_N;
  };
  Defect defect_;
  std::mt19937 draw_;
  double moves_s_, magnitude_, delay_s_;
  Vec3 amplitude_m_, frequency_Hz_;
  Plant plant_;
  std::deque<Written> written_;  ///< The first is the one that counts.
  std::uint64_t lastWrite_ns_ = 0, began_ns_ = 0, time_ns_ = 0, nextSample_ns_ = 0;
  Vec3 motor_N_{0};
  Position sample_;

  [[nodiscard]] double between(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(draw_);
  }
  [[nodiscard]] HandPreset drawnHand();
  [[nodiscard]] double drawnMagnitude();
  [[nodiscard]] Vec3 target(double time_s) const;
  void moveTo(std::uint64_t now_ns);
  [[nodiscard]] Vec3 motor();
  void sample();
};

}  // namespace haptics::test

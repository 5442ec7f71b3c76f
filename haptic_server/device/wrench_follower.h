#pragma once

#include <cstdint>

#include "common/mailbox/triple_buffer.h"
#include "common/telemetry/added_wrench.h"

namespace haptics {

/// The wrench that a client adds, as it comes and goes: towards the newest command at kForceRate and kTorqueRate, and away
/// kHeld_s after the last one.
class WrenchFollower {
 public:
  static constexpr double kForceRate_N_per_s = 30, kTorqueRate_Nm_per_s = 0.3;
  static constexpr double kHeld_s = 0.1;

  explicit WrenchFollower(double period_s) noexcept
      : forceStep_N_(kForceRate_N_per_s * period_s),
        torqueStep_Nm_(kTorqueRate_Nm_per_s * period_s),
        heldTicks_(static_cast<std::uint64_t>(kHeld_s / period_s)) {}

  /// For one thread besides the servo's: the newest counts. Wait-free.
  void command(const Wrench& wrench) noexcept { newest_.put(wrench); }

  /// The servo's, once a tick: what acts in it.
  [[nodiscard]] const AddedWrench& next() noexcept {
    if (const Wrench* const newest = newest_.takeNew()) {
      wanted_ = *newest;
      left_ = heldTicks_;
    } else if (left_ > 0 && --left_ == 0) {
      wanted_ = {};
    }
    if (now_.acts || left_ > 0) {
      now_ = AddedWrench({towards(now_.force_N, wanted_.force_N, forceStep_N_),
                          towards(now_.torque_Nm, wanted_.torque_Nm, torqueStep_Nm_)});
    }
    return now_;
  }

 private:
  [[nodiscard]] static Vec3 towards(Vec3 from, Vec3 to, double step) noexcept {
    const Vec3 way = to - from;
    const double length = glm::length(way);
    return length > step ? from + way * (step / length) : to;
  }

  const double forceStep_N_, torqueStep_Nm_;
  const std::uint64_t heldTicks_;
  TripleBuffer<Wrench> newest_;
  // The servo's.
  Wrench wanted_;
  std::uint64_t left_ = 0;  // ticks for which it is still wanted
  AddedWrench now_;
};

}  // namespace haptics

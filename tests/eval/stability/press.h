#pragma once

#include "haptic_server/device/presets.h"
#include "tests/eval/stability/methods.h"

namespace haptics::eval {

/// A device and a hand that press on a place: as they are, whatever a method is told of them.
struct Press {
  DevicePreset device;
  HandPreset hand;
  double period_s = 1e-3;
  double delay_s = 0;  ///< From the reading to the motor's force, beyond the hold.
  double force_N = 1;
  /// Speed at which it meets the surface, from a little above; 0: begins at rest on it, and the force is there at once.
  double tap_m_per_s = 0;
};

/// How it came to rest.
struct Settling {
  double cycle_m = 0;   ///< Peak to peak of the worst axis in the last 0.3 s, beneath the encoder.
  bool steady = false;  ///< No more than max(2 encoder steps, 20 um), and still there.
};

/// In virtual time.
[[nodiscard]] Settling restUnder(StabilityMethod& method, const Ground& ground, const Press& press);

/// The ways of pressing by which stability is judged: 0.5 and 1 N at once, and taps at 0.02 and 0.15 m/s.
struct PressKind {
  double force_N, tap_m_per_s;
};
[[nodiscard]] const std::vector<PressKind>& pressKinds();

}  // namespace haptics::eval

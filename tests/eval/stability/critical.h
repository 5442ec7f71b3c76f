#pragma once

#include "tests/eval/stability/press.h"

namespace haptics::eval {

/// Of one loop: who renders what for whom.
struct Loop {
  const MethodEntry* method = nullptr;
  const Ground* ground = nullptr;
  DevicePreset device;
  HandPreset hand;
  double rate_Hz = 1000;
  double delay_s = 0;
  double damping_Ns_per_m = 0;
  /// What the method is told, where that is not so.
  const DevicePreset* toldDevice = nullptr;
  double toldDelayMore_s = 0;
};

/// The worst of all ways of pressing.
[[nodiscard]] Settling restOf(const Loop& loop, double stiffness_N_per_m);

/// How closely, as a ratio of neighbouring stiffnesses: a search first climbs by `climb`, then halves down to `close`.
struct Search {
  double least_N_per_m = 50;
  double most_N_per_m = 200e3;
  double climb = 1.3;
  double close = 1.05;
};

/// Largest stiffness (N/m) up to which every one that was tried comes to rest; 0 when the least does not.
[[nodiscard]] double criticalStiffness_N_per_m(const Loop& loop, const Search& search);

}  // namespace haptics::eval

#pragma once

#include "haptic_server/servo/stability_search.h"
#include "tests/eval/stability/methods.h"

namespace haptics::eval {

/// Of one loop: who renders what for whom.
struct Loop {
  const MethodEntry* method = nullptr;
  const TestSurface* ground = nullptr;
  DevicePreset device;
  HandPreset hand;
  double rate_Hz = 1000;
  double delay_s = 0;
  double damping_Ns_per_m = 0;
  /// What the method is told, where that is not so.
  const DevicePreset* toldDevice = nullptr;
  double toldDelayMore_s = 0;
};

/// Largest stiffness (N/m) up to which every one that was tried comes to rest in every way of pressing; 0 when the least does
/// not.
[[nodiscard]] double criticalStiffness_N_per_m(const Loop& loop, const StabilitySearch& search = kStiffnessSearch);

}  // namespace haptics::eval

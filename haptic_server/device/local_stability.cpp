#include "haptic_server/device/local_stability.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace haptics {
namespace {

[[nodiscard]] bool isLocallyStable(const DeviceInfo& device, double period_s, double stiffness) noexcept {
  const double made = stiffness * period_s / 2 - device.viscousFriction_Ns_per_m;
  if (2 * device.coulombFriction_N < stiffness * device.resolution_m) return false;
  const double frequency = std::sqrt(stiffness / device.apparentMass_kg);
  return made * std::numbers::pi * frequency * kDisturbance_m <= 4 * device.coulombFriction_N;
}

}  // namespace

double locallyStableStiffness_N_per_m(const DeviceInfo& device, double period_s) noexcept {
  if (!(device.apparentMass_kg > 0)) return std::numeric_limits<double>::infinity();
  constexpr double kStiffest_N_per_m = 1e6;  // beyond any device
  constexpr int kHalvings = 60;
  double stable = 0;
  double unstable = kStiffest_N_per_m;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (stable + unstable) / 2;
    (isLocallyStable(device, period_s, middle) ? stable : unstable) = middle;
  }
  return stable;
}

}  // namespace haptics

#pragma once

#include "haptic_server/device/device.h"

namespace haptics {

/// Fraction of the critical stiffness that a surface may have: devices are not as their data sheets say.
inline constexpr double kStabilityMargin = 0.5;

/// Largest stiffness (N/m) of an undamped wall on which the device comes to rest (settling.h), by simulation of the device as
/// its data sheet has it under the production step: in nobody's hand and in a light one, in all ways of pressing. Every
/// stiffness that was tried up to it comes to rest, which are at least those that `haptic_eval stability` tries, and so does
/// kStabilityMargin of it. At most 200 kN/m; 0 where none of 50 N/m does. Infinite for a device of which the mass is
/// not known. With the server's observer, or without (stabilised). Takes some 40 ms of two processors at 1 kHz, in
/// proportion to the rate.
[[nodiscard]] double criticalStiffness_N_per_m(const DeviceInfo& device, double rate_Hz, bool stabilised);

/// The same of the damping (Ns/m) of walls up to a stiffness (N/m), judged on the stiffest and on one of 300 N/m: at most
/// 200 Ns/m. Some damping makes a contact stabler, more makes it ring by itself. 0 where the wall rings with 0.1 Ns/m.
/// Infinite for a device of which the mass is not known. Takes twice as long.
[[nodiscard]] double criticalDamping_Ns_per_m(const DeviceInfo& device, double rate_Hz, bool stabilised,
                                              double stiffest_N_per_m);

/// Largest torsion (Nm/rad) by which a tool that cannot turn may be held: criticalStiffness_N_per_m() of
/// rotationAsTranslation(). Infinite for a device that gives no torque, or of which the inertia is not known.
[[nodiscard]] double criticalTorsion_Nm_per_rad(const DeviceInfo& device, double rate_Hz, bool stabilised);

/// The most that a surface may have, and a tool: kStabilityMargin of what is critical.
struct SurfaceLimits {
  double stiffness_N_per_m = 0;
  double damping_Ns_per_m = 0;
  double torsion_Nm_per_rad = 0;

  bool operator==(const SurfaceLimits&) const = default;
};
[[nodiscard]] SurfaceLimits surfaceLimits(const DeviceInfo& device, double rate_Hz, bool stabilised);

}  // namespace haptics

#pragma once

#include "haptic_server/device/device.h"

namespace haptics {

/// Largest stiffness (N/m) of a wall on which the device comes to rest, by simulation of the device as its data sheet has
/// it, in nobody's hand: pushed with 0.5 and 1 N from rest on the wall, and tapped on it. At rest is what moves no more
/// than two encoder steps or 20 um. Stabilised as the server does it, or not; above 4 kHz that of 4 kHz, which is less. No
/// less than 300 N/m, for softer walls come to rest more slowly than is waited for. Infinite for a device of which the
/// mass is not known. Takes some 50 ms.
[[nodiscard]] double criticalStiffness_N_per_m(const DeviceInfo& device, double rate_Hz, bool stabilised);

/// The same of the damping (Ns/m) of walls up to a stiffness (N/m), judged on the stiffest and on one of 300 N/m: at most
/// 200 Ns/m. Some damping makes a contact stabler, more makes it ring by itself. 0 where the wall rings without. Infinite
/// for a device of which the mass is not known. Takes some 60 ms.
[[nodiscard]] double criticalDamping_Ns_per_m(const DeviceInfo& device, double rate_Hz, bool stabilised,
                                              double stiffest_N_per_m);

/// Of what is critical, the part that a surface may have: devices are not as their data sheets say.
inline constexpr double kSafePart = 0.5;

}  // namespace haptics

#pragma once

#include "haptic_server/device/device.h"

namespace haptics {

/// Largest stiffness (N/m) of a spring, without damping, at which a device that nobody holds stays locally stable at a
/// servo period of `period_s`: a disturbance dies out though the spring, sampled and quantised, makes energy (Diolaiti et
/// al., "Stability of Haptic Rendering: Discretization, Quantization, Time Delay, and Coulomb Effects", 2006).
///
///  - K <= 2 f_c / q: Coulomb friction holds what one encoder step q makes, else there is a limit cycle at rest.
///  - K <= 2 b / T, where it is passive; or a disturbance of kDisturbance_m is within the radius
///    4 f_c / (pi w (K T / 2 - b)), w = sqrt(K / m), inside of which Coulomb friction takes more energy in an oscillation
///    than sampling makes: f_c of the first harmonic's equivalent damping, 4 f_c / (pi w X), against K T / 2 - b.
///
/// Infinite for a device of which the mass is not known. The passive limit alone would not do: it is 100 N/m for a
/// Phantom at 1 kHz.
[[nodiscard]] double locallyStableStiffness_N_per_m(const DeviceInfo& device, double period_s) noexcept;

/// A hand that lets go or trembles moves the device so far. Larger is safer and makes textures weaker.
inline constexpr double kDisturbance_m = 1e-3;

}  // namespace haptics

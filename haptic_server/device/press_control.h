#pragma once

#include "common/telemetry/hand_command.h"  // kForceReserve

namespace haptics {

// How a simulated hand, exploring or led, presses with a force: it goes deeper as long as it feels less. Metres, newtons,
// seconds.

/// 1/s. How fast it corrects the force, if all compliance were its own; people need some tenths of a second. Faster
/// follows bumps better and starts to oscillate on the lag of kFeltSmoothing_s.
inline constexpr double kForceCorrection_per_s = 6;
inline constexpr double kFeltSmoothing_s = 0.03;     ///< Time constant of the felt force.
inline constexpr double kPressSpeed_m_per_s = 0.05;  ///< At most, into a surface.
/// That the hand's own spring yields at most while it presses: a loose hand presses lightly. Pressed with N, a hand of
/// stiffness k slips off ridges whose radius is less than N/k, since nothing but its spring holds it sideways.
inline constexpr double kMaxYield_m = 0.01;
/// That it goes into an object, besides its own yielding, before it concludes that there is none.
inline constexpr double kMaxIndentation_m = 0.015;
inline constexpr double kMaxPressDepth_m = kMaxYield_m + kMaxIndentation_m;

}  // namespace haptics

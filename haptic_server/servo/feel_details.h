#pragma once

#include "haptic_server/servo/felt_tick.h"
#include "haptic_server/servo/haptic_state.h"

namespace haptics {

/// Section 4 of the paper, for scenes in which some object has surface properties: force shading gives the direction
/// N_s, a texture adds its height to the depth and turns the force, a spring with a damper acts along N_s, and friction
/// follows from what is felt along it.
///
/// @param[in,out] felt  Its contact as it is held; then as it is felt: IHIP, N_s and depth with shading and texture,
/// touching also where only a bump reaches the HIP. Forces, height and friction are added.
void feelDetails(const ServoScene& scene, HapticState& state, const StepConfig& config, FeltTick& felt) noexcept;

}  // namespace haptics

#pragma once

#include "common/telemetry/telemetry_sample.h"
#include "haptic_server/servo/haptic_state.h"

namespace haptics {

/// Section 4 of the paper, for scenes in which some object has surface properties: force shading gives the direction
/// N_s, a texture adds its height to the depth and turns the force, a spring with a damper acts along N_s, and friction
/// follows from what is felt along it.
///
/// On return `contact` is as it is felt: IHIP, N_s and depth with shading and texture; touching also where only a bump
/// reaches the HIP. Forces, height and friction go to the sample.
void feelDetails(const ServoScene& scene, HapticState& state, const StepConfig& config, ContactResult& contact,
                 TelemetrySample& sample) noexcept;

}  // namespace haptics

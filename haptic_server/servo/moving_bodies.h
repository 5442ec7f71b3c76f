#pragma once

#include "haptic_server/servo/haptic_state.h"

namespace haptics {

/// Bodies take the poses to which the last tick moved them. Before the contact, which is then solved in their frames.
void takeMovedPoses(HapticState& state) noexcept;

/// Moves every awake body by a tick, those that hold the IHIP pushed by what the hand feels of them, friction and texture
/// included (paper 5c). After the contact: the two are coupled once in a tick.
/// @param force_N  On the hand, world: of the contact, before blend and limit; each surface that holds the IHIP is given
/// what it has of that along its normal, the first one the rest.
void moveBodies(HapticState& state, const StepConfig& config, const ContactResult& contact, Vec3 force_N) noexcept;

}  // namespace haptics

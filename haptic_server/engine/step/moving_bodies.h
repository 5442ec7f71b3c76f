#pragma once

#include "haptic_server/engine/step/force_result.h"
#include "haptic_server/engine/step/haptic_state.h"

namespace haptics {

/// Bodies take the poses to which the last tick moved them. Before the contact, which is then solved in their frames.
void takeMovedPoses(HapticState& state) noexcept;

/// About what moving bodies take in any case in moveBodies() of this tick; at most half of the tick's allowance. Units.
[[nodiscard]] std::int64_t unitsOfMotion(const HapticState& state) noexcept;

/// Moves every awake body by a tick, those that hold the IHIP pushed by what the hand feels of them, friction and texture
/// included (paper 5c). After the contact: the two are coupled once in a tick. Where that takes more than half of the
/// tick's allowance, or than the contact has left of it, bodies that the hand does not push move in turn, each by all the
/// ticks for which it waited.
/// @param result  Its force on the hand is written already; each surface that holds the IHIP is given its share of the
/// contact's, before the limits, along its normal, the first one the rest. A body that is stopped for good fades from under
/// the hand as one that leaves the scene does. Of a second hand's state nothing moves (followMovedBodies()).
void moveBodies(HapticState& state, const StepConfig& config, const ForceResult& result) noexcept;

/// What a second hand gives the bodies of the first in this tick, and which of them an edit still holds in its state. Between
/// both hands' computeForce() and the first's moveBodies(), whose bodies are pushed by both.
void takePushes(HapticState& first, const HapticState& second, const ForceResult& secondResult) noexcept;

/// In place of moveBodies() for the second hand, after that of the first: its bodies are to go where the first's have gone.
void followMovedBodies(const HapticState& first, HapticState& second, const ForceResult& secondResult) noexcept;

/// Where the bodies were for the tick just made, stopped ones included.
/// @param[in,out] motion  As of an earlier tick.
/// @return Whether anything differs from that.
[[nodiscard]] bool updateMotionState(const HapticState& state, std::uint64_t tick, MotionState& motion) noexcept;

}  // namespace haptics

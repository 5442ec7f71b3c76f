#pragma once

#include <cstddef>

#include "common/telemetry/telemetry_sample.h"
#include "haptic_server/engine/step/force_result.h"
#include "haptic_server/engine/step/haptic_step.h"

// Two hands in one scene. Each has a device, a state and a step of its own, so that either's force, limits and faults are
// those of a hand alone. What they share is the bodies that move: the state of the first hand moves them, by what both give.
namespace haptics {

/// The most that one servo may have.
inline constexpr std::size_t kMaxHands = 2;

/// Of each of two hands: half of a tick's allowance, so that both together take no longer than one alone.
[[nodiscard]] StepConfig perHandConfig(StepConfig config) noexcept;

/// Makes of a new state the second hand's: its bodies go where those of the first go, it holds no tool, and what it presses
/// into plastic tissue goes back.
void followFirstHand(HapticState& second) noexcept;

/// One hand's tick after computeForce().
struct HandTick {
  const ServoScene&
      scene;  ///< That its state has adopted. The other's may be another one while a contact fades for an edit.
  HapticState& state;
  const StepConfig& config;
  const StepInput& input;
  const ForceResult& result;
};

/// finishStep() of both, once both forces are written. Bodies move by the sum of what the hands give them. A body whose pose
/// was edited stands still until it is where the edit has it in the state of either hand.
void finishSteps(const HandTick& first, const HandTick& second, TelemetrySample& firstSample,
                 TelemetrySample& secondSample) noexcept;

}  // namespace haptics

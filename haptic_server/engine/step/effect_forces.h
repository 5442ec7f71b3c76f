#pragma once

#include "haptic_server/engine/step/haptic_step.h"

namespace haptics {

/// Goes over to the effects of another scene, each from the one with the same object and number. Call before bodies, objects and
/// scene are taken over.
/// @param origins  Of the next scene's objects.
/// @param bodies  Likewise.
/// @param moving  Likewise.
void adoptEffects(const ServoScene& next, std::span<const BodyOrigin> origins, std::span<const Body> bodies,
                  std::span<const MovingBody> moving, HapticState& state) noexcept;

/// Adds the effects' forces at the HIP to what is felt of the surfaces. Those in an object's frame move and turn with it, and
/// push it back (pushOfEffects()).
void addEffectForces(const ServoScene& scene, HapticState& state, const StepConfig& config, const StepInput& input,
                     ForceResult& result) noexcept;

/// What of the felt force the contact has.
[[nodiscard]] inline Vec3 contactForce_N(const HapticState& state, const ForceResult& result) noexcept {
  return state.features.effects ? result.force.contact - state.effectsFelt.force_N : result.force.contact;
}

/// What the effects of each body that moves have of what the slew limit lets in or out in this tick.
/// @param withinBefore  What was left, likewise, of what was felt in the tick before.
void shareRest(HapticState& state, double withinBefore) noexcept;

/// What the effects in the frame of a body push it with: the opposite of what the hand has of them, after every limit.
[[nodiscard]] Push pushOfEffects(const HapticState& state, std::size_t body, Vec3 written_N) noexcept;

}  // namespace haptics

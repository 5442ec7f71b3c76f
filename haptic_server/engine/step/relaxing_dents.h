#pragma once

#include "haptic_server/engine/step/haptic_state.h"

namespace haptics {

[[nodiscard]] inline double depth_m(const Dent& dent) noexcept { return glm::length(Vec3(dent.displacement)); }

[[nodiscard]] inline Dent scaled(Dent dent, double share) noexcept {
  dent.displacement *= static_cast<float>(share);
  return dent;
}

/// Whether a dent is deep enough to stay where it is plastic, rather than to go back.
[[nodiscard]] bool leavesMark(const Dent& dent, const SoftTissue& tissue) noexcept;

/// A dent goes a part of its way to what it comes to: `left` of the way is left.
void comeToRest(BodyDent& dent, double left) noexcept;

/// Puts a mark in the place before a dent, whose number it takes: a contact that moves on leaves it behind. It grows from
/// nothing, far enough from the contact not to be felt. Without a place for it there is none.
/// @return Whether there is one; the dent is then at the next place.
bool leaveMark(HapticState& state, std::size_t at, const Dent& mark) noexcept;

/// One tick of the dents that nothing presses: they go to what they come to, and those that are gone leave their places.
void relaxDents(const ServoScene& scene, HapticState& state, const StepConfig& config) noexcept;

}  // namespace haptics

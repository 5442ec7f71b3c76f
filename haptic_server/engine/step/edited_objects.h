#pragma once

#include <cstddef>

#include "haptic_server/engine/contact/contact.h"
#include "haptic_server/engine/step/haptic_state.h"

namespace haptics {

/// What a body's felt stiffness moves to, at a factor of 1: none of one that leaves the scene.
[[nodiscard]] inline Stiffness ownStiffness(const ServoScene& scene, const HapticState& state,
                                            std::size_t body) noexcept {
  const ServoObject& object = scene.objects[body];
  return state.bodies[body].pendingRemoval ? Stiffness{} : Stiffness{object.stiffness_N_per_m, object.damping_Ns_per_m};
}

/// A tick of a body's felt stiffness towards its own.
/// @param depth_m, speed_m_per_s  Of its spring; 0 where it is not felt.
void updateStiffness(const ServoScene& scene, HapticState& state, const StepConfig& config, std::size_t body,
                     double depth_m, double speed_m_per_s) noexcept;

/// The same of the touched body where it is rigid and smooth; with others that hold the IHIP it has a part of the
/// penetration.
void updateTouchedStiffness(const ServoScene& scene, HapticState& state, const StepConfig& config,
                            const ContactResult& contact, double speed_m_per_s) noexcept;
/// The same of all others: they hold the IHIP beside that, or not at all, and are then there at once.
void updateUntouchedStiffness(const ServoScene& scene, HapticState& state, const StepConfig& config,
                              const ContactResult& contact) noexcept;

/// Where some are being moved or leave: objects that were edited under the stylus go on to where the scene has them, those
/// that are driven to where they are to be (kinematic_motion.h), and the contact with one that leaves ends once that is not
/// felt any more: what is behind it is felt then.
void followEdits(const ServoScene& scene, HapticState& state, const StepConfig& config) noexcept;

/// In a fault, in which nobody feels them, objects that were edited under the stylus are at once where the scene has them.
void endEdits(HapticState& state) noexcept;

}  // namespace haptics

#pragma once

#include "haptic_server/engine/step/haptic_step.h"

namespace haptics {

/// On touching a surface with a tap, a sinusoid that decays, along its normal (Okamura, Cutkosky & Dennerlein 2001); README.md.
/// @param part  Of the last tap's force that was written.
/// @param way  Of the hand since then, world.
/// @return The force on the hand (N, world), and by how much it changed because of the time.
[[nodiscard]] EffectsFelt feelTap(const ServoScene& scene, HapticState& state, const StepConfig& config,
                                  const ContactResult& contact, double part, Vec3 way) noexcept;

}  // namespace haptics

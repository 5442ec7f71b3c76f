#pragma once

#include "haptic_server/geometry/allowance.h"
#include "haptic_server/motion/rigid_body.h"

namespace haptics {

/// Finds where a body will reach its planes within the tick, and gives it the impulses that keep it out of them and rub
/// it along them (sequential impulses: Catto 2005; Guendelman et al. 2003): at each point in turn, as much as stops that
/// point's approach, never a pull; across it, as much as stops the sliding, at most Coulomb's part of that. The sums of
/// one tick are the first guess of the next, so that a body at rest is solved before the first round.
/// A point that is still away may close its distance within the tick and no more: nothing sinks in, nothing rebounds.
/// @param state  Momenta after this tick's other forces; written: momenta and `touching`.
/// @param allowance  Once it is spent, no more rounds are made than a body at rest needs.
void meetPlanes(const RigidBody& body, RigidState& state, double period_s, Allowance& allowance) noexcept;

/// Lifts a body that has sunk into a plane, by rounding or because it was put there, by a part of its depth.
void leavePlanes(const RigidBody& body, RigidState& state) noexcept;

}  // namespace haptics

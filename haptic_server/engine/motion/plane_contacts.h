#pragma once

#include "haptic_server/engine/geometry/allowance.h"
#include "haptic_server/engine/motion/rigid_body.h"

namespace haptics {

/// What the motions of a tick may still take together, in units of Allowance.
struct MotionAllowance {
  Allowance least;   ///< For what a motion takes in any case: spent, never looked at here.
  Allowance rounds;  ///< For rounds beyond those that a body at rest needs, which end once it is spent.
};

/// Finds where a body will reach its planes within the tick, and gives it the impulses that keep it out of them and rub
/// it along them (sequential impulses: Catto 2005; Guendelman et al. 2003): at each point in turn, as much as stops that
/// point's approach, never a pull; across it, as much as stops the sliding, at most Coulomb's part of that. The sums of
/// one tick are the first guess of the next, so that a body at rest is solved before the first round.
/// A point that is still away may close its distance within the tick and no more: nothing sinks in, nothing rebounds.
/// @param state  Momenta after this tick's other forces; written: momenta and `touching`.
void solvePlaneContacts(const RigidBody& body, RigidState& state, double period_s, MotionAllowance& allowance) noexcept;

/// A support point by a plane.
struct NearPlane {
  std::uint16_t plane = 0;
  std::uint16_t point = 0;  ///< Index into RigidBody::support.
  Vec3 arm_m{0};            ///< From the centre of mass, world.
  double gap_m = 0;         ///< Above the plane; below it negative.
  Vec3 last_Ns{0};          ///< Impulse of the last tick, world.
};
using NearPlanes = std::array<NearPlane, kMaxPlanes * kPointsOnPlane>;
/// Those that may reach their plane within the tick, and span what the body stands on. Returns how many there are.
[[nodiscard]] std::size_t findNearPlanes(const RigidBody& body, const RigidState& state, double period_s,
                                         NearPlanes& found, Allowance& allowance) noexcept;

/// About what solvePlaneContacts() will spend of MotionAllowance::least, units.
[[nodiscard]] std::int64_t leastPlaneUnits(const RigidBody& body, const RigidState& state) noexcept;

/// Lifts a body that has sunk into a plane, by rounding or because it was put there, by a part of its depth.
void leavePlanes(const RigidBody& body, RigidState& state) noexcept;

}  // namespace haptics

#pragma once

#include "haptic_server/engine/motion/plane_contacts.h"
#include "haptic_server/engine/motion/rigid_body.h"

namespace haptics {

/// One tick of a body under gravity, damping, springs, joints, planes and the stylus' push (paper 5c: "dynamical
/// equations are solved using the Euler integration technique, and the state of each object is updated at every
/// iteration"). Wait-free, bounded work. Bodies that meet one another: haptic_server/engine/collision.
///
/// Deviations from the paper:
///  - Semi-implicit (symplectic) Euler: the new velocity moves the body. Explicit Euler, with the old one, gains energy
///    without end: a pendulum of 0.7 s gains a factor of 17 in a minute at 1 kHz, and this one nothing.
///  - Turns by the angular velocity at the middle of the tick's turn, which keeps the energy of a spinning asymmetric body
///    as well as its angular momentum.
///  - Damping is implicit, and springs no stiffer than the tick can hold: no parameter makes a body unstable.
///  - A body at rest sleeps: it costs a comparison until it is pushed. A push keeps it awake.
/// @param push  Of the hand, N, at a place in the world, m.
/// @param period_s  Of the tick; of several where the body has waited for its turn.
/// @param allowance  Of the tick: what the motion takes is spent of it.
void moveRigidBody(const RigidBody& body, RigidState& state, const Push& push, double period_s,
                   MotionAllowance& allowance) noexcept;

// ---- Its parts, for bodies that meet others in between ----

/// Momentum (on a joint: rate) after a tick of everything but what the body meets.
void driveRigidBody(const RigidBody& body, RigidState& state, const Push& push, double period_s) noexcept;
/// Moves and turns it by a tick with the momentum that it has.
void advanceRigidBody(const RigidBody& body, RigidState& state, double period_s) noexcept;
/// Where a body is, free or on a joint.
struct RigidPlace {
  Vec3 centre_m;
  Quat axes;
  double coordinate;
};
[[nodiscard]] inline RigidPlace placeOf(const RigidState& state) noexcept {
  return {state.centre_m, state.axes, state.coordinate};
}
/// False: the body is not finite, or beyond the world, and has been stopped where it was before.
[[nodiscard]] bool keepInWorld(const RigidBody& body, RigidState& state, const RigidPlace& before) noexcept;
/// Whether it has been still for kStill_s, this tick included.
[[nodiscard]] bool isStill(const RigidBody& body, RigidState& state, const Push& push, double period_s) noexcept;
/// It has no momentum from here on.
void stop(RigidState& state, BodyCondition why) noexcept;

/// About what moveRigidBody() will spend of MotionAllowance::least, units.
[[nodiscard]] std::int64_t leastMotionUnits(const RigidBody& body, const RigidState& state) noexcept;

/// A body of which no point has moved farther than this in so long falls asleep, also one that drifts with no friction.
/// Where it has moved, not how fast it moves: a pendulum stands still at its turning points, and a body on a plane may
/// tremble by parts of a micrometre. Farther or sooner would stop what still visibly moves.
inline constexpr double kStill_m = 20e-6;
inline constexpr double kStill_s = 0.5;

}  // namespace haptics

#pragma once

#include <span>

#include "haptic_server/engine/collision/body_pairs.h"
#include "haptic_server/engine/motion/plane_contacts.h"

namespace haptics {

/// What is left out where bodies that meet take more than they may.
struct CollisionAllowance {
  /// Of the points at which bodies touch. Where it does not last, the bodies wait for a tick; and also where a search that
  /// took more than half of it has found more contacts than the rest would pay for.
  Allowance search;
  MotionAllowance motion;
};

/// One tick of bodies that meet one another: forces, contacts, and where they get to. A tick has two steps or more, each a
/// substep of the soft step (Catto 2024, Box2D 3): sequential impulses with the last step's as first guess, points that are
/// still apart may close their gap and no more, overlap goes by a damped spring of at most kPushApart_m_per_s; the bodies
/// move; and the impulses are solved again without the spring, so that what pushed bodies apart leaves them little speed.
/// Coulomb friction, no rebound. What touches nothing moves by the whole tick.
/// Bodies in contact sleep together, once all of them are still, and wake together. Wait-free.
/// @param bodies  At most kMaxColliders; their poses are those at the tick's start.
/// @return False: the allowance did not last, and the bodies wait; or there was no room for some pairs, which pass through
/// each other.
bool moveTogether(std::span<Collider> bodies, BodyPairs& pairs, double period_s,
                  CollisionAllowance& allowance) noexcept;

/// About what moveTogether() will spend of MotionAllowance::least, motions apart; units.
[[nodiscard]] std::int64_t leastCollisionUnits(const BodyPairs& pairs) noexcept;

/// Bodies that overlap come apart at this speed at most.
inline constexpr double kPushApart_m_per_s = 0.1;

}  // namespace haptics

#pragma once

#include <span>

#include "haptic_server/contact/contact.h"

namespace haptics {

/// Of a free HIP that is known to be some way off everything: whether it still is at `hip` (world, metres), bodies having
/// moved meanwhile. Then nothing can have been met on the way. Takes what they moved off what is known.
[[nodiscard]] bool staysClear(std::span<const Body> bodies, ContactState& state, const Vec3& hip) noexcept;

/// After a tick that ended free: finds out how far the nearest thing is, if that seems worth it. It is where the HIP, as
/// fast as in this tick, needs a while to get there.
/// @param step_m  That the HIP went in the tick.
void lookForClearance(std::span<const Body> bodies, ContactState& state, double step_m, Allowance& allowance) noexcept;

}  // namespace haptics

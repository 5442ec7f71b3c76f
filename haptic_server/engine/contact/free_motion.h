#pragma once

#include "haptic_server/engine/contact/tick_context.h"

namespace haptics {

/// Moves a free IHIP with the HIP, from time `now` to `end` of the tick, where the near bodies are already. Where a
/// body is entered on the way the contact begins there. Returns the time reached.
/// @param hip  At `end`, world.
[[nodiscard]] double advanceFree(TickContext& tick, double now, double end, Vec3 hip) noexcept;

/// Moves the IHIP off the surface that holds it, from its foot to h, the HIP in the body's frame. Free then, unless a
/// surface is entered on the way.
void leaveSurface(TickContext& tick, const ClosestPoint& foot, Vec3 h, Vec3 hip) noexcept;

}  // namespace haptics

#pragma once

#include "haptic_server/engine/contact/tick_context.h"

namespace haptics {

/// Units (Allowance) of heldUntil().
inline constexpr std::int64_t kBisection = 24 * 600;

/// Takes the IHIP over from the surface walk, where that is blocked or at a boundary, for the HIP `hip` (world).
void takeOver(TickContext& tick, Vec3 hip) noexcept;
/// Moves the IHIP to the point nearest to the HIP (world) that all surfaces in the way leave.
void solvePlanes(TickContext& tick, Vec3 hip) noexcept;

/// Has a moving body not completed its motion yet? That is part of the IHIP's first move, which cannot be divided in the world.
[[nodiscard]] bool hasPendingBodyMotion(const TickContext& tick) noexcept;
/// After solvePlanes() for a HIP that went `step_m`: has the IHIP jumped, or a surface that held `before` let go?
[[nodiscard]] bool mayHaveJumped(const TickContext& tick, const Checkpoint& before, double step_m) noexcept;
/// Bisects for the time, within kMinStep, at which a triangle that holds ends under the IHIP; `end` when none does.
[[nodiscard]] double heldUntil(const TickContext& tick, double now, double end) noexcept;

}  // namespace haptics

#pragma once

#include <optional>

#include "haptic_server/engine/contact/tick_context.h"

namespace haptics {

/// May the tick have left the IHIP inside of a body?
[[nodiscard]] bool mayBeInside(const TickContext& tick) noexcept;
/// The closed body that the IHIP is inside of at the end of the tick, or the sheet that it is behind; -1 when there is
/// none, or when the allowance is spent.
[[nodiscard, gnu::noinline]] int enclosingBody(TickContext& tick) noexcept;
/// Puts the IHIP, free, where it is outside of all bodies, and gathers what is near there. None when no such place is
/// known before the allowance is spent.
[[nodiscard, gnu::noinline]] std::optional<Vec3> placeOutside(TickContext& tick) noexcept;

}  // namespace haptics

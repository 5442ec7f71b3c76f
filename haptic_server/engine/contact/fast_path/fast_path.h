#pragma once

#include <span>

#include "haptic_server/engine/contact/fast_path/follow_polygon.h"

// Common ticks without steps, paths and guards: they change no bit of a result, only the time.

namespace haptics {

/// followContact() where one surface at rest holds the IHIP and nothing blocks it, for a HIP that is usable. False when
/// there is more to it, and then nothing is written but the cache, and the allowance that the look took.
[[nodiscard]] bool followUnblocked(std::span<const Body> bodies, ContactState& state, const Vec3& hip,
                                   ContactResult& result, ContactCache& cache) noexcept;

}  // namespace haptics

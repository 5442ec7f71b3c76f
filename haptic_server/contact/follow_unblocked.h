#pragma once

#include <span>

#include "haptic_server/contact/contact.h"

namespace haptics {

/// The common tick by a short way: a HIP that rubs slowly over one surface, everything in reach at rest, nothing that
/// blocks the IHIP. Does what followContact() does then, bit for bit, at a fraction of the cost. Returns false, with
/// nothing changed, whenever there is more to it.
[[nodiscard]] bool followUnblocked(std::span<const Body> bodies, ContactState& state, const Vec3& hip,
                                   ContactResult& result) noexcept;

/// Every tick, by the long way. Into a `result` as constructed.
void followGuarded(std::span<const Body> bodies, ContactState& state, const Vec3& hip, ContactResult& result) noexcept;

}  // namespace haptics

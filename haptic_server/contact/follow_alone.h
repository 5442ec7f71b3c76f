#pragma once

#include <span>

#include "haptic_server/contact/contact.h"

namespace haptics {

/// The tick of a HIP that rubs over one body at rest, slowly, with nothing else in reach: what followContact() does then,
/// bit for bit, at a fraction of the cost. Returns false, with nothing changed, whenever there is more to it.
[[nodiscard]] bool followAlone(std::span<const Body> bodies, ContactState& state, Vec3 hip,
                               ContactResult& result) noexcept;

}  // namespace haptics

#pragma once

#include <span>

#include "haptic_server/contact/body.h"

namespace haptics {

/// A place near `from` (world, metres) that is outside of all closed bodies where they are at the end of the tick, but for
/// those that are leaving the scene; `from` when it is. For a point that moving bodies have come over:
///  - the nearest place above the planes of all that it is found in, as long as there is one, that is while what they
///    close in is open to some side;
///  - else the nearest place in any of fifteen directions, `outward` (unit) the first of them, be it on the other side
///    of a body.
/// `skin` (metres) clear of the surfaces where these leave room for it. Bounded: some 300 closest point queries.
[[nodiscard]] Vec3 wayOut(std::span<const Body> bodies, Vec3 from, Vec3 outward, double skin) noexcept;

}  // namespace haptics

#pragma once

#include <optional>
#include <span>

#include "haptic_server/engine/contact/near_bodies.h"

namespace haptics {

/// Budget of a depenetration, at some 25 ns a triangle and 1 us a segment. More finds nearer places among many fine
/// bodies.
inline constexpr int kMaxDepenetrationTriangles = 4096;
inline constexpr int kMaxDepenetrationSegments = 96;

/// A place near `from` (world, metres) that is outside of all closed bodies where they are at the end of the tick, but
/// for those that are leaving the scene, and on the same side of every sheet of `near` as the last place that is known
/// to be clear of it; `from` when it is. For a point that moving bodies have come over:
///  - the nearest place above the planes of all bodies that it is found in or behind, as long as they leave a side
///    open;
///  - else the nearest place in any of fifteen directions, `outward` (unit) the first of them, be it on the other side
///    of a body. `skin` (metres) clear of the surfaces where these leave room for it. A mesh that passes through itself
///    is left where its winding number becomes 0. Bounded to some 200 us: spends the two budgets, and a little more,
///    then takes the best place so far, at worst the first one outside of all on the segment from far out. Adds to
///    `work`. None when the allowance is spent before a place is known.
[[nodiscard]] std::optional<Vec3> findDepenetration(std::span<const Body> bodies, const NearBodies& near, Vec3 from,
                                                    Vec3 outward, double skin, ContactWork& work) noexcept;

}  // namespace haptics

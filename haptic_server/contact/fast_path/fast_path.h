#pragma once

#include <span>

#include "haptic_server/contact/contact.h"
#include "haptic_server/contact/neighborhood_watch.h"

// Short ways for common ticks. They change no bit, only the time: without this folder, and where it is called, everything
// else stays as it is.

namespace haptics {

/// followContact(): by a short way where there is one, else by followGuarded(). Returns whether there was one: the HIP rubs
/// slowly over one surface, everything in reach at rest and nothing that blocks the IHIP, or is free and far from all.
bool followFast(std::span<const Body> bodies, ContactState& state, const Vec3& hip, ContactResult& result,
                const TriangleCache* cache) noexcept;

/// neighborhoodWatch() from triangle `start` in its common case, across the lines that are closest to h. False when there
/// is more to it: the general search then goes on from triangle `start`, which is yet to be looked at.
[[nodiscard]] bool walkAcrossLines(const CollisionMesh& surface, std::uint32_t& start, Vec3 h, SearchPath* path,
                                   int& spent, int budget, SearchResult& found) noexcept;

}  // namespace haptics

#pragma once

#include "haptic_server/engine/contact/search_path.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// neighborhoodWatch() from triangle `start` in its common case, across the lines that are closest to h. False when
/// there is more to it: the general search then goes on from triangle `start`, which is yet to be looked at.
[[nodiscard]] bool walkAcrossLines(const CollisionMesh& surface, std::uint32_t& start, Vec3 h, SearchRun& run,
                                   SearchResult& found) noexcept;

}  // namespace haptics

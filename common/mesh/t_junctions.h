#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/mesh/tri_mesh.h"

namespace haptics {

using EdgeIndices = std::array<std::uint32_t, 2>;

/// Number of the boundary edges (those with one face) on which another end of a boundary edge lies: the faces meet
/// there, but not edge to edge, and the edge is open. On means strictly between the ends and within 2^-20 of the mesh's
/// extent. None when edges that pass many ends without meeting one would make the search take more than a few seconds.
[[nodiscard]] std::optional<std::uint64_t> countTJunctions(const std::vector<Vec3f>& vertices,
                                                           const std::vector<EdgeIndices>& boundary);

}  // namespace haptics

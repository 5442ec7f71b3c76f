#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/mesh/tri_mesh.h"
#include "common/mesh/work.h"

namespace haptics {

using EdgeIndices = std::array<std::uint32_t, 2>;

/// Number of the boundary edges (those with one face) on which another end of a boundary edge lies: the faces meet
/// there, but not edge to edge, and the edge is open. On means strictly between the ends and within 2^-20 of the mesh's
/// extent. None when the work does not suffice: edges pass too many ends without meeting one.
[[nodiscard]] std::optional<std::uint64_t> countTJunctions(const std::vector<Vec3f>& vertices,
                                                           const std::vector<EdgeIndices>& boundary, Work& work);
/// Limit of the search's work. A sane mesh needs up to 80 units an edge.
[[nodiscard]] inline Work tJunctionAllowance(std::size_t boundaryEdges) { return {boundaryEdges, 160}; }

}  // namespace haptics

#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh/tri_mesh.h"

namespace haptics {

/// Of each vertex, which one it becomes: itself, or one of a lower number.
struct JoinedVertices {
  std::vector<std::uint32_t> becomes;
  std::uint64_t joined = 0;  ///< Those that become another one.
};

/// Closes cracks: an open edge, of one face, whose ends lie within `within_m` (metres) of those of another one that runs the other way
/// becomes one edge with it. Surfaces that lie on one another, whose edges run the same way, stay apart, as does all that has no open edge.
/// No vertex moves by more than twice that. Near-linear: where very many edges are in one place some are left.
[[nodiscard]] JoinedVertices joinOpenEdges(const TriMesh& mesh, double within_m);

}  // namespace haptics

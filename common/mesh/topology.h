#pragma once

#include "common/mesh/import.h"

namespace haptics {

/// Fills in what the kept mesh itself tells: edges by kind, duplicate faces, valence, mean edge, bounding box. Overwrites.
void describeTopology(const TriMesh& mesh, MeshReport& report);

}  // namespace haptics

#pragma once

#include "common/mesh/tri_mesh.h"
#include "common/scene/surface_edits.h"
#include "common/scene/surface_properties.h"

namespace haptics {

/// What an edit left open of a mapping's intermediate surface becomes that of the mesh's box in its frame.
void fitToMesh(const MappedSource& source, const TriMesh& mesh, Mapping& mapping);

}  // namespace haptics

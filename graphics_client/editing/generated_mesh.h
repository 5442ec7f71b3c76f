#pragma once

#include <optional>

#include "common/mesh/tri_mesh.h"
#include "haptics/v1/scene.pb.h"

namespace haptics {

/// The box, sphere, cylinder or torus of which this mesh comes, vertex for vertex. Nothing: none of few digits is known.
[[nodiscard]] std::optional<v1::MeshSource> generatorOf(const TriMesh& mesh);

}  // namespace haptics

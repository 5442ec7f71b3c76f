#pragma once

#include <variant>

#include "common/error/error.h"
#include "common/mesh/tri_mesh.h"
#include "common/scene/scene.h"

namespace haptics {

/// Input of a mesh generator.
using MeshRecipe = std::variant<BoxSource, SphereSource, CylinderSource, TorusSource>;

/// In this thread, for as long as it takes. Refused, naming the field below MeshSource ("sphere.radius_m"): what the
/// generators refuse.
[[nodiscard]] Result<TriMesh> generate(const MeshRecipe& recipe);
/// How many it makes.
[[nodiscard]] double trianglesOf(const MeshRecipe& recipe) noexcept;

}  // namespace haptics

#pragma once

#include "tests/eval/worst/import_families.h"
#include "tests/haptic_server/engine/geometry/shapes.h"

namespace haptics::eval {

/// A mesh in one of four formats, its triangles shuffled or not, by a number in [0, 1).
[[nodiscard]] MeshFile fileOf(shapes::Shape shape, double gene);
/// Polygons as an OFF file. `polygons`: the corners of each.
[[nodiscard]] MeshFile fileOf(const std::vector<Vec3f>& vertices,
                              const std::vector<std::vector<std::uint32_t>>& polygons);

}  // namespace haptics::eval

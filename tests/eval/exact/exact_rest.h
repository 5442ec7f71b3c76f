#pragma once

#include <span>
#include <vector>

#include "common/maths/vec.h"
#include "common/mesh/tri_mesh.h"

namespace haptics::eval {

/// Where an IHIP can rest on a closed, welded mesh that does not pass through itself, for a HIP inside of it: the places of the
/// surface that no place near them, outside or on it, is nearer to the HIP than. Decided in rational numbers, by CGAL's exact
/// kernel, without a tolerance: of each triangle, edge and vertex whether the HIP's foot is there, and whether any way along
/// the triangles around it, or out of the body, leads nearer. Knows no path, no hierarchy and no neighbours of the server.
/// Of a mesh that is not closed: for a HIP behind it; none on its rim. Object frame, metres; rounded to double in the end.
[[nodiscard]] std::vector<Vec3> exactRests(std::span<const Vec3f> vertices, std::span<const TriangleIndices> triangles,
                                           Vec3 hip);

}  // namespace haptics::eval

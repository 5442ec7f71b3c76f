#pragma once

#include <cstdint>

#include "common/error/error.h"
#include "common/mesh/tri_mesh.h"

namespace haptics {

/// Closed, consistently oriented meshes centred at the origin, in canonical order. Refused, naming the argument: sizes
/// that are not finite and > 0, segment counts of 0 (below 3 around an axis), or more than kMaxTriangles.
[[nodiscard]] Result<TriMesh> makeBox(Vec3 size_m, std::uint32_t segmentsPerSide);
[[nodiscard]] Result<TriMesh> makeSphere(double radius_m, std::uint32_t segmentsPerCubeEdge);  ///< 12 n^2 triangles.
[[nodiscard]] Result<TriMesh> makeCylinder(double radius_m, double height_m,
                                           std::uint32_t segmentsAround);  ///< Axis z.
[[nodiscard]] Result<TriMesh> makeTorus(double majorRadius_m, double minorRadius_m, std::uint32_t majorSegments,
                                        std::uint32_t minorSegments);  ///< Axis z; minor < major.

}  // namespace haptics

#pragma once

#include <cstdint>

#include "common/mesh/tri_mesh.h"

namespace haptics {

/// Repairs of a mesh that intersects itself.
struct RepairReport {
  std::uint64_t selfIntersections = 0;      ///< Pairs of triangles that passed through each other.
  std::uint64_t selfIntersectionsLeft = 0;  ///< That still do.
  std::uint64_t trianglesCut = 0;
  std::uint64_t trianglesFilled = 0;  ///< In their place.
  /// Largest distance from what was cut out to what replaces it, cracks aside: thin ones are filled however deep they
  /// are.
  double farthest_m = 0;
  bool searched = true;  ///< False: the search would have taken too long; nothing was done.
  bool finished = true;  ///< False: mending all of them would have taken too long; some were not tried.
};

/// Of the longest side of the mesh's box: how far mending may change the surface.
/// Larger mends worse scans, and changes what is felt and seen farther from the scan's points.
inline constexpr double kMaxRepairDistance = 1.0 / 128;

/// Cuts out where a mesh passes through itself, as scans do where two sides of a surface nearly touch, over as few rings
/// as it takes, and closes the holes. Only where one piece of surface does so: pieces that overlap are meant to. What
/// cannot be mended within `farthest_m` stays as it was, and so does everything when the mesh is not `closed`, because a
/// sheet may have been meant to. Vertices stay where they are; those that nothing names any more are gone.
[[nodiscard]] RepairReport repairSelfIntersections(TriMesh& mesh, bool closed, double farthest_m);

}  // namespace haptics

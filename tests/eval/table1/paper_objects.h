#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/mesh/tri_mesh.h"

namespace haptics::eval {

struct MeshCounts {
  std::uint64_t vertices = 0;
  std::uint64_t lines = 0;
  std::uint64_t polygons = 0;
  std::uint64_t boundaryLines = 0;  ///< Of one polygon.

  bool operator==(const MeshCounts&) const = default;
};

[[nodiscard]] MeshCounts countsOf(const TriMesh& mesh);

/// An object of the paper's Table I, rebuilt from its counts, or one beyond.
struct TableObject {
  std::string_view name;
  double paperLow_kHz = 0;  ///< The paper's rate; 0: not in the paper.
  double paperHigh_kHz = 0;
  TriMesh mesh;
};

/// The same surface for the HIP's path: about x, a cap of a sphere of kTableRadius_m, or, for the first, a flat side
/// where the path is at the same depth. The paper's second and third object are open, as their counts imply: 22 and 100
/// boundary lines (2 lines - 3 polygons). The second is a ball without caps; the third, whose Euler number is -48, two
/// such balls, one in the other, joined by 24 tunnels on the far side. Throws std::logic_error when a mesh does not have
/// the paper's counts.
[[nodiscard]] std::vector<TableObject> tableObjects(int finest);

inline constexpr double kTableRadius_m = 0.05;
inline constexpr double kTableDepth_m = 0.002;
/// Of the circle that the HIP goes round, about x.
inline constexpr double kTablePathRadius_m = 0.02;
/// x of that circle: kTableDepth_m below the sphere.
[[nodiscard]] double tablePathHeight_m();

}  // namespace haptics::eval

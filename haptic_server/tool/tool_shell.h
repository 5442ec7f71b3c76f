#pragma once

#include <cstddef>
#include <vector>

#include "common/error/error.h"
#include "common/maths/vec.h"
#include "haptic_server/geometry/collision_mesh.h"

namespace haptics {

/// Points of a tool's surface: the tool touches where they do. Tool frame, metres.
struct ToolShell {
  std::vector<Vec3> points;
  double radius_m = 0;  ///< Of the sphere about the frame's origin through the farthest point.
};

/// Most points that a shell may have.
inline constexpr std::size_t kMaxToolPoints = 8192;
/// Lines whose faces' normals differ by more (30 degrees) are sharp: points lie on them, closer than `spacing`.
inline constexpr double kSharp_rad = 0.5235987755982988;

/// Samples a surface so that no two points are nearer than the spacing and no place of it is farther than that from one
/// (Poisson-disk sampling by dart throwing over a fixed sequence of darts: the same mesh gives the same points). Vertices
/// and lines that are sharp come first. **Deviation** from sampling every vertex: those within smooth parts are places like
/// any other, or a tool of fine triangles would have more points than its spacing says.
/// Refused: a spacing that is not positive, a shell of more than kMaxToolPoints.
[[nodiscard]] Result<ToolShell> makeToolShell(const CollisionMesh& mesh, double spacing_m);

/// The sharp corners and points of sharp lines alone, of what a tool of this spacing may meet: what is thin enough to come
/// between two of its points has some. Object frame. Where there are more than kMaxToolPoints the spacing is doubled until
/// there are not.
[[nodiscard]] std::vector<Vec3> sharpPoints(const CollisionMesh& mesh, double spacing_m);

}  // namespace haptics

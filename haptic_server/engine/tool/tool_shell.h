#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "common/error/error.h"
#include "common/maths/vec.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// Points of a tool's surface: the tool touches where they do. Tool frame, metres.
struct ToolShell {
  std::vector<Vec3> points;
  double radius_m = 0;  ///< Of the sphere about the frame's origin through the farthest point.
};

/// A mesh that the hand holds in place of a point.
struct Tool {
  std::shared_ptr<const CollisionMesh> surface;
  ToolShell shell;  ///< Of the surface.
};

/// Most points that a shell may have.
inline constexpr std::size_t kMaxToolPoints = 8192;

/// Samples a surface so that no two points are nearer than the spacing and no place of it is farther than that from one
/// (Poisson-disk sampling by dart throwing over a fixed sequence of darts: the same mesh gives the same points). Vertices
/// and lines that are sharp come first. **Deviation** from sampling every vertex: those within smooth parts are places like
/// any other, or a tool of fine triangles would have more points than its spacing says.
/// Refused: a spacing that is not positive, a shell of more than kMaxToolPoints.
[[nodiscard]] Result<ToolShell> makeToolShell(const CollisionMesh& mesh, double spacing_m);

}  // namespace haptics

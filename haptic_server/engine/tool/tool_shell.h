#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/error/error.h"
#include "common/maths/vec.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// Points of a tool's surface: the tool touches where they do. Tool frame, metres.
struct ToolShell {
  std::vector<Vec3> points;  ///< Those at the spacing, then the vertices that are none of these.
  std::size_t spaced = 0;    ///< How many are at the spacing.
  double nearVertex_m = 0;   ///< Every vertex is so near to a point.
  double radius_m = 0;       ///< Of the sphere about the frame's origin through the farthest point.
};

/// What a tool has that opens and closes: half of its opening turns the upper jaw about the axis, half of it the lower one
/// back. Tool frame, closed.
struct ToolJaws {
  Vec3 hinge_m{0};  ///< On the axis.
  Vec3 axis{0, 1, 0};
  std::shared_ptr<const CollisionMesh> lower;
  std::size_t firstOfLower = 0;  ///< Of the shell's points.
};

/// A mesh that the hand holds in place of a point.
struct Tool {
  std::shared_ptr<const CollisionMesh> surface;  ///< Of the upper jaw, where it has jaws.
  ToolShell shell;                               ///< Of the surface; of both jaws.
  std::optional<ToolJaws> jaws = std::nullopt;
};

/// Most points that a shell may have.
inline constexpr std::size_t kMaxToolPoints = 8192;
/// A vertex nearer to a point than this is no point of its own: larger ones leave it deeper inside what is touched, smaller
/// ones follow what cannot be distinguished.
inline constexpr double kNearVertex_m = 5e-6;

/// Darts thrown for a shell: fewer leave holes, more take time. With more than kMaxDarts it is refused.
[[nodiscard]] constexpr double dartsFor(double area_m2, double spacing_m) noexcept {
  constexpr double kPerDisk = 32;  // of the spacing
  return kPerDisk * area_m2 / (spacing_m * spacing_m);
}
inline constexpr double kMaxDarts = 4e6;

/// Samples a surface so that no two points are nearer than the spacing and no place of it is farther than that from one
/// (Poisson-disk sampling by dart throwing over a fixed sequence of darts: the same mesh gives the same points). Vertices
/// and lines that are sharp come first. All vertices that are farther than kNearVertex_m from these points are points too; where
/// that would be more than 1,000 and give more than 2,000 points in all, or more than kMaxToolPoints, than the least double
/// of it, and double again, with which it does not.
/// Refused: a spacing that is not positive, one that alone gives more than kMaxToolPoints.
[[nodiscard]] Result<ToolShell> makeToolShell(const CollisionMesh& mesh, double spacing_m);

/// Where the jaws of a tool are held together. Tool frame.
struct JawHinge {
  Vec3 place_m{0};      ///< On the axis.
  Vec3 axis{0, 1, 0};   ///< About which they open: unit.
  Vec3 reach{1, 0, 0};  ///< From the hinge between the jaws: unit, at a right angle to the axis.
};

/// A tool of two jaws, closed as the mesh has them: what is on the side of axis x reach of the plane through axis and reach
/// is the upper one, the rest the lower one. The shell's radius is that of any opening. Refused: as by makeToolShell(); a
/// triangle on both sides, or a vertex nearer to the plane than kNearVertex_m; nothing on one of them.
[[nodiscard]] Result<Tool> makeJaws(std::span<const Vec3f> vertices,
                                    std::span<const std::array<std::uint32_t, 3>> triangles, const JawHinge& hinge,
                                    double spacing_m);

}  // namespace haptics

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/maths/vec.h"
#include "haptic_server/engine/collision/polytope.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// The places of a body that meet the surfaces of others: its sharp corners, points of its sharp lines, and the vertices of
/// what is round. Flat parts need none, for the corners and lines of what lies on them do. In a tree of spheres.
struct CollisionPoints {
  struct Node {
    Vec3 centre{0};
    double radius_m = 0;
    std::uint32_t begin = 0, end = 0;  ///< Points.
    std::uint32_t next = 0;            ///< The node after this one and all below it. A leaf's is the next one.
  };

  struct Point {
    Vec3 place{0};   ///< Object frame, m.
    Vec3 normal{0};  ///< Of the body there, unit: of the faces that meet.
  };

  std::vector<Point> points;         ///< At most kMaxCollisionPoints.
  std::vector<Node> nodes;           ///< In the order in which they are visited; [0] holds all points.
  std::optional<Polytope> polytope;  ///< Where the mesh is one: two such bodies meet by their faces and edges instead.
  double friction = 0.5;             ///< Coulomb's coefficient; of two bodies the geometric mean counts.
  double rolling_m = 2e-4;           ///< As a Plane's; of two bodies the mean counts.
};

inline constexpr std::size_t kMaxCollisionPoints = 1024;
/// Points are so far apart, of the mesh's radius: on sharp lines, where closer ones find sooner that two of them cross, and on
/// what is round, where closer ones let it roll smoother. Both take longer.
inline constexpr double kSharpSpacing = 1.0 / 16, kRoundSpacing = 1.0 / 8;

/// Without friction and rolling. Deterministic. Where there are too many points, the spacings are doubled until there are not.
/// For the builder thread.
[[nodiscard]] CollisionPoints makeCollisionPoints(const CollisionMesh& mesh);

}  // namespace haptics

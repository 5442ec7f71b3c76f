#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/maths/vec.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// A closed convex mesh as flat faces: a brick, a board, a wedge, a cylinder, a ball, however finely it is meshed. Object
/// frame, metres.
struct Polytope {
  static constexpr std::size_t kMaxCorners = 1024, kMaxFaces = 2 * kMaxCorners, kMaxOfFace = 64;
  /// Of one that meets others of the kind by separating axes.
  static constexpr std::size_t kFewFaces = 24, kFewCorners = 32, kFewOfFace = 16, kFewDirections = 8;
  using Corner = std::uint16_t;  ///< Index into corners.
  using FaceIndex = std::uint16_t;

  struct Face {
    Vec3 normal;  ///< Unit, outward.
    double offset_m;
    std::uint32_t begin, end;  ///< Of the loops: its corners, counterclockwise from outside.
  };
  struct Edge {
    Corner from, to;
    std::uint8_t direction;  ///< Index into directions.
  };
  struct Side {
    Corner corner;   ///< The next one along an edge.
    FaceIndex face;  ///< The face to one side of it.
  };

  std::vector<Vec3> corners;
  std::vector<Face> faces;
  std::vector<Corner> loops;
  std::vector<std::uint32_t> around;  ///< The sides of corner c are [around[c], around[c + 1]).
  std::vector<Side> sides;
  Vec3 middle{0};                ///< The corners' mean.
  double radius_m = 0;           ///< About it.
  std::vector<Edge> edges;       ///< As the next: empty unless all is few.
  std::vector<Vec3> directions;  ///< Of the edges, unit; parallel ones share one.

  static constexpr int kCellsOfSide = 8;                       ///< In a row, on a side of a cube.
  std::array<Corner, 6 * kCellsOfSide * kCellsOfSide> begins;  ///< The farthest along the middles of its cells.

  [[nodiscard]] static std::size_t cellOf(Vec3 along) noexcept {
    const Vec3 size = glm::abs(along);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    constexpr double kHalf = kCellsOfSide / 2.0;
    const double perCell = kHalf / size[axis];
    const auto cell = [&](int d) noexcept {  // none, if it is no direction
      const double at = kHalf + along[d] * perCell;
      return at > 0 ? static_cast<std::size_t>(std::min(at, kCellsOfSide - 0.5)) : 0;
    };
    const std::size_t side = static_cast<std::size_t>(axis) * 2 + (along[axis] >= 0 ? 1 : 0);
    return (side * kCellsOfSide + cell(nextCorner(axis))) * kCellsOfSide + cell(previousCorner(axis));
  }
  [[nodiscard]] bool hasFew() const noexcept { return !edges.empty(); }
  [[nodiscard]] std::span<const Corner> loopOf(const Face& face) const noexcept {
    return std::span(loops).subspan(face.begin, face.end - face.begin);
  }
  [[nodiscard]] std::span<const Side> sidesOf(Corner corner) const noexcept {
    return std::span(sides).subspan(around[corner], around[corner + 1U] - around[corner]);
  }
  /// The corner that lies farthest along a direction.
  /// @param from  Where the climb begins; near the answer it takes less.
  [[nodiscard]] Corner farthest(Vec3 along, Corner from) const noexcept;
  /// One from which the climb is short.
  [[nodiscard]] Corner nearFarthest(Vec3 along) const noexcept { return begins[cellOf(along)]; }
  struct Above {
    const Face* face;
    double height_m;
  };
  /// The face above which a place is highest; negative: it is inside. The place is no nearer than that.
  /// @param near  A corner, at best near the place; afterwards one that is.
  [[nodiscard]] Above above(Vec3 at, Corner& near) const noexcept;
  /// Of the faces at a corner the one that looks most along a direction.
  [[nodiscard]] const Face& facingAt(Corner corner, Vec3 along) const noexcept;
};

/// Absent where the mesh is not such a one: open, bent inward by more than rounding, or of too many faces. For the builder
/// thread.
[[nodiscard]] std::optional<Polytope> polytopeOf(const CollisionMesh& mesh);
/// The convex hull of a round mesh, of vertices at least kHullSpacing of its radius apart, where it is the mesh but for
/// kHullError of its radius. Absent where it is not, or the mesh is open. For the builder thread.
[[nodiscard]] std::optional<Polytope> hullOf(const CollisionMesh& mesh);
inline constexpr double kHullSpacing = 1.0 / 28, kHullError = 0.006;

}  // namespace haptics

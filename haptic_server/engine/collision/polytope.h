#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/maths/vec.h"
#include "haptic_server/engine/geometry/collision_mesh.h"

namespace haptics {

/// A closed convex mesh of few flat faces: a brick, a board, a wedge, a prism, however finely it is meshed. Object frame,
/// metres.
struct Polytope {
  static constexpr std::size_t kMaxFaces = 24, kMaxCorners = 32, kMaxOfFace = 16, kMaxDirections = 8;
  using Corner = std::uint8_t;  ///< Index into corners.

  struct Face {
    Vec3 normal;  ///< Unit, outward.
    double offset_m;
    std::uint8_t begin, end;  ///< Of the loops: its corners, counterclockwise from outside.
  };
  struct Edge {
    Corner from, to;
    std::uint8_t direction;  ///< Index into directions.
  };

  std::vector<Vec3> corners;
  std::vector<Face> faces;
  std::vector<Corner> loops;
  std::vector<Edge> edges;
  std::vector<Vec3> directions;  ///< Of the edges, unit; parallel ones share one.

  [[nodiscard]] std::span<const Corner> loopOf(const Face& face) const noexcept {
    return std::span(loops).subspan(face.begin, static_cast<std::size_t>(face.end - face.begin));
  }
};

/// Absent where the mesh is not such a one: open, bent inward by more than rounding, or of too many faces. For the builder
/// thread.
[[nodiscard]] std::optional<Polytope> polytopeOf(const CollisionMesh& mesh);

/// Where two polytopes meet: a face of one and what of the other is near it, or the closest places of two edges.
struct PolytopeContact {
  struct Point {
    std::uint32_t id;  ///< The same while the same corners and sides make it; less than kIds.
    Vec3 on;           ///< Of the body that touches; second's frame, as the others.
    Vec3 foot;         ///< Below it, on the other's face.
    double gap_m;
  };
  static constexpr std::uint32_t kIds = 1U << 20U;

  Vec3 normal{0};         ///< Unit, out of the second towards the first.
  double gap_m = 0;       ///< Along it; negative: how deep. The distance of the two is no less.
  bool ofSecond = false;  ///< Points of the second body touch a face of the first; else the other way round.
  std::size_t count = 0;
  std::array<Point, 2 * Polytope::kMaxOfFace> points;

  [[nodiscard]] std::span<const Point> all() const noexcept { return std::span(points).first(count); }
};

/// What polytopes that meet are to keep to.
struct PolytopeWay {
  double range_m = 0;  ///< Farther places are left out.
  double step_m = 0;   ///< Edges of flush faces that are no deeper do not stop a body that passes them.
  Vec3 linear{0};  ///< Velocity of the first against the second at the second's origin; second's frame, as the others.
  Vec3 angular{0};
  Vec3 normal{0};  ///< Of the last tick, out of the second; 0: none. They are not turned over to the other side of it.
};

/// What contactOf() costs; units (Allowance).
[[nodiscard]] std::int64_t contactUnits(const Polytope& first, const Polytope& second) noexcept;

/// By separating axes (Gottschalk, Lin and Manocha 1996): the one along which they are least deep, or farthest apart.
/// Wait-free.
/// @param relative  Pose of the first in the second's frame.
/// @return Without points where none is within the range.
[[nodiscard]] PolytopeContact contactOf(const Polytope& first, const Polytope& second, const Pose& relative,
                                        const PolytopeWay& way) noexcept;

}  // namespace haptics

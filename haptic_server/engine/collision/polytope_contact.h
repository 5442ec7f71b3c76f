#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "common/maths/vec.h"
#include "haptic_server/engine/collision/polytope.h"
#include "haptic_server/engine/contact/frame.h"

namespace haptics {

/// Where two polytopes meet: a face of one and what of the other is near it, or the closest places of two edges.
struct PolytopeContact {
  struct Point {
    std::uint32_t id;  ///< The same while the same corners and sides make it; less than kIds.
    Vec3 on;           ///< Of the body that touches; second's frame, as the others.
    Vec3 foot;         ///< Below it, on the other's face.
    double gap_m;
  };
  static constexpr std::uint32_t kIds = 1U << 20U;

  Vec3 normal{0};           ///< Unit, out of the second towards the first.
  double gap_m = 0;         ///< Along it; negative: how deep. The distance of the two is no less.
  bool isOneOfTwo = false;  ///< They are level along another axis as well, which counts once they come to it less fast.
  bool ofSecond = false;    ///< Points of the second body touch a face of the first; else the other way round.
  std::int64_t units = 0;   ///< What it took (Allowance).
  std::size_t count = 0;
  std::array<Point, 2 * Polytope::kMaxOfFace> points;  // not initialised

  [[nodiscard]] std::span<const Point> all() const noexcept { return std::span(points).first(count); }
};

/// What polytopes that meet are to keep to.
struct PolytopeWay {
  double range_m = 0;  ///< Farther places are left out.
  double step_m = 0;   ///< Edges of flush faces that are no deeper do not stop a body that passes them.
  Vec3 linear{0};  ///< Velocity of the first against the second at the second's origin; second's frame, as the others.
  Vec3 angular{0};
  Vec3 normal{0};  ///< Of the last tick, out of the second; 0: none. They are not turned over to the other side of it.
  Vec3 guess{0};   ///< A direction near which that of the nearest places may be, out of the second; 0: none.

  [[nodiscard]] bool isTurnedOver(Vec3 axis) const noexcept {
    constexpr double kOpposite = 0.5;  // cosine, below minus this
    return glm::dot(axis, normal) < -kOpposite;
  }
};

/// By separating axes (Gottschalk, Lin and Manocha 1996): the one along which they are least deep, or farthest apart.
/// Wait-free.
/// @param relative  Pose of the first in the second's frame.
/// @return Without points where none is within the range.
[[nodiscard]] PolytopeContact contactOf(const Polytope& first, const Polytope& second, const Pose& relative,
                                        const PolytopeWay& way) noexcept;

/// Likewise of two polytopes one of which has many faces: by their distance (Gilbert, Johnson and Keerthi 1988), the one with
/// more faces made a little smaller, or, where they overlap by more, along the faces' normals.
[[nodiscard]] PolytopeContact contactOfRound(const Polytope& first, const Polytope& second, const Pose& relative,
                                             const PolytopeWay& way) noexcept;

/// A flat part of another body's surface. In a frame of its own.
struct FlatPart {
  std::array<Vec3, 3> corners;  ///< Counterclockwise seen from outside.
  Vec3 normal;                  ///< Unit, outward.
};

/// How far a polytope is above the triangle's plane, at least; negative: how deep below. Wait-free.
/// @param pose  The polytope's, in the triangle's frame.
/// @param nearest  A corner; afterwards the one that is nearest to the plane, unless all are farther than the range.
[[nodiscard]] double heightOver(const Polytope& polytope, const Frame& pose, const FlatPart& part, double range_m,
                                Polytope::Corner& nearest) noexcept;
/// What of the polytope's face that looks most at the triangle is above it, no nearer to its plane than `range_m[0]` and no
/// farther than `range_m[1]`, as points of the polytope. Wait-free.
/// @param nearest  As heightOver() leaves it.
/// @param areCorners  Else also where its edges cross the triangle's.
[[nodiscard]] PolytopeContact contactOver(const Polytope& polytope, const Frame& pose, const FlatPart& part,
                                          std::array<double, 2> range_m, Polytope::Corner nearest,
                                          bool areCorners) noexcept;
/// Where a polytope and a triangle are nearest to each other. Absent where they overlap by more than a tenth of the
/// polytope. Wait-free.
/// @param nearest  The triangle's place that is nearest to the polytope's middle.
/// @param pose  The polytope's, the first's, in the frame of the triangle, the second.
[[nodiscard]] std::optional<PolytopeContact> contactOf(const Polytope& polytope, const FlatPart& part, Vec3 nearest,
                                                       const Pose& pose, double range_m) noexcept;

}  // namespace haptics

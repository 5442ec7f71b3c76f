#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "tests/eval/walk/triangle_soup.h"

namespace haptics::eval {

/// normal . x >= offset; world, metres.
struct Wall {
  Vec3 normal;  ///< Unit.
  double offset_m;
  std::size_t face;  ///< Of the Obstacles that it belongs to.
};

/// The triangles about a place, and what they keep a point from. The point stays a skin above them.
class Obstacles {
 public:
  struct Block {
    double time;  ///< Fraction of the way to the triangle itself.
    Wall wall;    ///< A skin above it.
  };

  /// `skin` in metres.
  Obstacles(const TriangleSoup& soup, double skin) : soup_(&soup), skin_(skin) {}

  /// Knows all triangles that meet the cube of half side `reach` (m) about the centre from now on, and no others.
  void gather(Vec3 centre, double reach);
  [[nodiscard]] std::size_t count() const { return faces_.size(); }

  [[nodiscard]] std::optional<Block> firstBlock(Vec3 from, Vec3 to) const;
  /// Fraction of the way from -> to for which all of these walls' triangles are still underneath.
  [[nodiscard]] double timeOnSupports(std::span<const Wall* const> walls, Vec3 from, Vec3 to) const;
  /// A place on a triangle.
  struct Place {
    Vec3 point;
    Vec3 beside;  ///< Of the same triangle, the point nearest to where it was looked for from.
  };
  /// Of the triangles that carry a point a skin above them, the point nearest to h.
  [[nodiscard]] std::optional<Place> nearestOfTouched(Vec3 at, Vec3 h) const;
  /// Have all triangles that a place lies on, to rounding, their point nearest to h there, and is h behind each of them?
  /// Then it is a local minimum of the distance, however near the end of those triangles is. False on a sheet's lines,
  /// where there may be a way round.
  [[nodiscard]] bool isMinimum(Vec3 place, Vec3 h) const;
  /// Is a point a skin above such a place?
  [[nodiscard]] bool isAboveMinimum(Vec3 at, Vec3 h) const;
  /// The walls at most `within` (m) from a point. Sheets are touched from the side of -`inward`.
  [[nodiscard]] std::vector<Wall> touching(Vec3 at, Vec3 inward, double within) const;
  [[nodiscard]] bool isSheet(const Wall& wall) const { return faces_[wall.face].sheet; }
  /// Of the wall's triangle.
  [[nodiscard]] Vec3 middle(const Wall& wall) const {
    const auto& corner = faces_[wall.face].corner;
    return (corner[0] + corner[1] + corner[2]) / 3.0;
  }

 private:
  struct Face {
    Vec3 normal;
    double offset_m;
    bool sheet;
    std::array<Vec3, 3> corner;
    std::array<Vec3, 3> inward;  // unit, in the plane, from each edge
    std::array<double, 3> inwardOffset_m;

    explicit Face(const TriangleSoup::Face& face);
    [[nodiscard]] double insideEdge(std::size_t k, Vec3 p) const { return glm::dot(inward[k], p) - inwardOffset_m[k]; }
    [[nodiscard]] double inside(Vec3 p) const {
      return std::min({insideEdge(0, p), insideEdge(1, p), insideEdge(2, p)});
    }
    [[nodiscard]] Wall wall(double side, double skin, std::size_t index) const {
      return {normal * side, offset_m * side + skin, index};
    }
  };

  const TriangleSoup* soup_;
  double skin_;
  std::vector<Face> faces_;
};

/// The place at or near `at` that is above all walls; `at` pushed off them in turn.
[[nodiscard]] Vec3 pushedOff(std::span<const Wall> walls, Vec3 at);

}  // namespace haptics::eval

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/maths/vec.h"

namespace haptics {

/// A place on a path: on the segment from its point `segment` to the next, at `part` of it, 0 to 1.
struct PathPlace {
  std::uint64_t segment = 0;
  double part = 0;
  Vec3 point{0};
  double squared_m2 = 0;  ///< Distance from what it is near to.
};

/// A polyline with a hierarchy of boxes over its segments. noexcept, no allocation once it is made.
class EffectPath {
 public:
  EffectPath() noexcept = default;  ///< Of no segments: of no place.
  /// @param points  At least two, no two in a row the same.
  explicit EffectPath(const std::vector<Vec3>& points);

  [[nodiscard]] std::size_t segmentCount() const noexcept { return segments_.size(); }
  /// On one segment.
  [[nodiscard]] PathPlace nearestOn(std::size_t segment, Vec3 x) const noexcept;
  /// On the whole path; where several are as near, that on `warm` or the one found first.
  /// @param warm  A segment to begin with: the nearer it is, the less is looked at.
  [[nodiscard]] PathPlace nearest(Vec3 x, std::size_t warm) const noexcept;
  /// From a place on, never back: over one segment after the other for as long as the next comes nearer. So where a path crosses
  /// itself the place stays on its branch.
  [[nodiscard]] PathPlace onwards(Vec3 x, std::uint64_t segment, double part) const noexcept;
  /// Unit, continuous along the path: that of the segments, turned evenly from the mean at one point to the mean at the next.
  [[nodiscard]] Vec3 tangent(const PathPlace& place) const noexcept;

 private:
  struct Segment {
    Vec3 begin, way;
    double perSquaredLength;
  };
  struct Box {
    Vec3 low, high;
    [[nodiscard]] double squaredDistance(Vec3 x) const noexcept {
      const Vec3 beyond = glm::max(glm::max(low - x, x - high), Vec3(0));
      return glm::dot(beyond, beyond);
    }
  };
  static constexpr std::size_t kLeaf = 4;  ///< Segments. More makes fewer boxes and more segments to look at.

  std::vector<Segment> segments_;
  std::vector<Vec3> tangents_;  // at the points
  std::vector<Box> boxes_;      // a complete tree: 1 is the root, 2 i and 2 i + 1 are below i
  std::size_t leaves_ = 0;      // a power of two: box leaves_ + i is over segments from kLeaf i on
};

}  // namespace haptics

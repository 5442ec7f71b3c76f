#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "common/maths/vec.h"

namespace haptics::eval {

/// A sphere of radius r against a triangle is a point against the triangle grown by r: its face offset by r to both
/// sides, a cylinder about each edge, a sphere about each corner. Any frame, metres.
class SweptSphere {
 public:
  /// Its centre moves straight from `from` by `way`.
  SweptSphere(Vec3 from, Vec3 way, double radius)
      : from_(from), way_(way), radius_(radius), grazing_(kGrazing * glm::length(way)) {}

  /// Fraction of the way at which it first touches the triangle on approach; `before` when it does not until then.
  [[nodiscard]] double firstTouch(const std::array<Vec3, 3>& corner, double before) const {
    if (outOfReach(corner, before)) return before;
    double first = std::min(before, faceTouch(corner));
    for (std::size_t k = 0; k < 3; ++k) {
      first = std::min(first, edgeTouch(corner[k], corner[(k + 1) % 3]));
      first = std::min(first, roundTouch(from_ - corner[k], way_));
    }
    return first;
  }

 private:
  /// Of the way: a sphere that approaches by less slides along, as rounding would have it.
  static constexpr double kGrazing = 1e-9;

  /// By the ball about the first corner that holds the triangle.
  [[nodiscard]] bool outOfReach(const std::array<Vec3, 3>& corner, double before) const {
    const Vec3 to = corner[0] - from_;
    const double way2 = squaredLength(way_);
    const double time = way2 > 0 ? std::clamp(glm::dot(to, way_) / way2, 0.0, before) : 0;
    const double size2 = std::max(squaredLength(corner[1] - corner[0]), squaredLength(corner[2] - corner[0]));
    const double reach = radius_ + std::sqrt(size2);
    return squaredLength(to - way_ * time) > reach * reach;
  }

  [[nodiscard]] double faceTouch(const std::array<Vec3, 3>& corner) const {
    Vec3 normal = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
    const double area = glm::length(normal);
    if (area == 0) return 1;
    normal /= area;
    double height = glm::dot(normal, from_ - corner[0]);
    if (height < 0) {
      normal = -normal;
      height = -height;
    }
    const double approach = -glm::dot(normal, way_);
    if (approach <= grazing_ || height - approach > radius_) return 1;
    const double time = std::max(0.0, (height - radius_) / approach);
    const Vec3 at = from_ + way_ * time;
    int sides = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      sides += glm::dot(normal, glm::cross(corner[(k + 1) % 3] - corner[k], at - corner[k])) >= 0 ? 1 : -1;
    }
    return std::abs(sides) == 3 ? time : 1;
  }

  [[nodiscard]] double edgeTouch(Vec3 a, Vec3 b) const {
    const double length = glm::distance(a, b);
    const Vec3 along = (b - a) / length;
    const auto across = [&](Vec3 v) { return v - along * glm::dot(along, v); };
    const double time = roundTouch(across(from_ - a), across(way_));
    const double place = glm::dot(along, from_ + way_ * time - a);
    return place >= 0 && place <= length ? time : 1;
  }

  /// Of a point that moves from `start` by `way` and the circle, or sphere, of the radius about the origin.
  [[nodiscard]] double roundTouch(Vec3 start, Vec3 way) const {
    const double approach = -glm::dot(start, way);
    if (approach <= grazing_ * radius_) return 1;
    const double way2 = squaredLength(way);
    const double discriminant = approach * approach - way2 * (squaredLength(start) - radius_ * radius_);
    if (discriminant < 0) return 1;
    return std::clamp((approach - std::sqrt(discriminant)) / way2, 0.0, 1.0);
  }

  Vec3 from_;
  Vec3 way_;
  double radius_;
  double grazing_;  // metres
};

}  // namespace haptics::eval

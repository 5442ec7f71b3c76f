#include "tests/eval/fuzz/solid_oracle.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include "tests/eval/closest_on_triangle.h"

namespace haptics::eval {
namespace {

/// Winding numbers are whole but for rounding.
constexpr double kHalf = 0.5;
constexpr std::size_t kGroup = 8;  ///< Faces.

double squaredDistanceToBox(Vec3 p, Vec3 low, Vec3 high) {
  return squaredLength(glm::max(glm::max(low - p, p - high), Vec3(0)));
}

}  // namespace

SolidOracle::SolidOracle(std::span<const Vec3f> vertices, std::span<const TriangleIndices> triangles)
    : low_(std::numeric_limits<double>::infinity()), high_(-std::numeric_limits<double>::infinity()) {
  constexpr double kUlp = 0x1p-23;
  for (const TriangleIndices& triangle : triangles) {
    for (const std::uint32_t v : triangle) {
      const Vec3 size = glm::abs(Vec3(vertices[v]));
      rounding_m_ = std::max(rounding_m_, kUlp * std::max({size.x, size.y, size.z}));
    }
    Face face;
    for (std::size_t k = 0; k < 3; ++k) face.corner[k] = turned(Vec3(vertices[triangle[k]]));
    face.low = glm::min(face.corner[0], glm::min(face.corner[1], face.corner[2]));
    face.high = glm::max(face.corner[0], glm::max(face.corner[1], face.corner[2]));
    low_ = glm::min(low_, face.low);
    high_ = glm::max(high_, face.high);
    if (faces_.size() % kGroup == 0) groups_.push_back(face);
    groups_.back() = {glm::min(groups_.back().low, face.low), glm::max(groups_.back().high, face.high)};
    faces_.push_back(face);
  }
}

template <class Meets, class Is>
bool SolidOracle::anyFace(Meets meets, Is is) const {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (!meets(groups_[g])) continue;
    const std::size_t first = g * kGroup, count = std::min(kGroup, faces_.size() - first);
    for (const Face& face : std::span(faces_).subspan(first, count)) {
      if (meets(face) && is(face)) return true;
    }
  }
  return false;
}

Vec3 SolidOracle::turned(Vec3 point) {
  static const Quat kOdd = glm::angleAxis(0.7853, glm::normalize(Vec3(0.311, 0.533, 0.787)));
  return kOdd * point;
}

bool SolidOracle::isInBox(Vec3 turned) const {
  return glm::all(glm::greaterThan(turned, low_)) && glm::all(glm::lessThan(turned, high_));
}

/// Of the ray along x, those out of the mesh less those into it: the winding number but where the ray meets an edge. What
/// it says is confirmed by the solid angles before it counts.
int SolidOracle::crossingsAbove(Vec3 p) const {
  int crossings = 0;
  const auto onRay = [&](const Box& box) {
    return p.y >= box.low.y && p.y <= box.high.y && p.z >= box.low.z && p.z <= box.high.z && p.x <= box.high.x;
  };
  const auto count = [&](const Face& face) {
    const auto& [a, b, c] = face.corner;
    const auto area = [&](Vec3 u, Vec3 v) { return (u.y - p.y) * (v.z - p.z) - (u.z - p.z) * (v.y - p.y); };
    const Vec3 part{area(b, c), area(c, a), area(a, b)};
    const bool out = part.x > 0 && part.y > 0 && part.z > 0;
    const bool in = part.x < 0 && part.y < 0 && part.z < 0;
    if (!out && !in) return false;
    const double x = glm::dot(part, Vec3(a.x, b.x, c.x)) / (part.x + part.y + part.z);
    if (x > p.x) crossings += out ? 1 : -1;
    return false;  // all are counted
  };
  (void)anyFace(onRay, count);
  return crossings;
}

/// Van Oosterom and Strackee, The Solid Angle of a Plane Triangle (1983).
double SolidOracle::windingAt(Vec3 turned) const {
  double angle = 0;
  for (const Face& face : faces_) {
    const Vec3 a = face.corner[0] - turned;
    const Vec3 b = face.corner[1] - turned;
    const Vec3 c = face.corner[2] - turned;
    const double la = glm::length(a);
    const double lb = glm::length(b);
    const double lc = glm::length(c);
    angle += 2 * std::atan2(glm::dot(a, glm::cross(b, c)),
                            la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return angle / (4 * std::numbers::pi);
}

double SolidOracle::distanceFrom(Vec3 turned) const {
  double nearest = std::numeric_limits<double>::infinity();
  const auto mayBeNearer = [&](const Box& box) { return squaredDistanceToBox(turned, box.low, box.high) < nearest; };
  const auto measure = [&](const Face& face) {
    nearest = std::min(nearest, squaredLength(closestOnTriangle(turned, face.corner) - turned));
    return false;  // there may be a nearer one
  };
  (void)anyFace(mayBeNearer, measure);
  return std::sqrt(nearest);
}

bool SolidOracle::isNearTurned(Vec3 turned, double within) const {
  return anyFace(
      [&](const Box& box) { return squaredDistanceToBox(turned, box.low, box.high) <= within * within; },
      [&](const Face& face) { return glm::distance(closestOnTriangle(turned, face.corner), turned) <= within; });
}

double SolidOracle::depth_m(Vec3 point) const {
  const Vec3 p = turned(point);
  if (!isInBox(p) || crossingsAbove(p) <= 0 || isNearTurned(p, rounding_m_)) return 0;
  return windingAt(p) > kHalf ? distanceFrom(p) : 0;
}

SolidOracle::Side SolidOracle::side(Vec3 point) const {
  const Vec3 p = turned(point);
  if (isNearTurned(p, rounding_m_)) return Side::kOnSurface;
  return isInBox(p) && crossingsAbove(p) > 0 ? Side::kInside : Side::kOutside;
}

}  // namespace haptics::eval

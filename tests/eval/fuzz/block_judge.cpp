#include "tests/eval/fuzz/block_judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace haptics::eval {
namespace {

constexpr double kParallel = 1e-6;  // sine below which two sides have no axis of their own
constexpr double kInner = 0.1;      // of a joint's size that a centre of mass keeps from its border

using Vec2 = glm::dvec2;

std::array<Vec3, 3> axesOf(const Block& block) {
  return {block.pose.rotation * Vec3(1, 0, 0), block.pose.rotation * Vec3(0, 1, 0),
          block.pose.rotation * Vec3(0, 0, 1)};
}

double reach(const Block& block, const std::array<Vec3, 3>& axes, Vec3 along) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) sum += block.half_m[i] * std::abs(glm::dot(axes[static_cast<std::size_t>(i)], along));
  return sum;
}

double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }

std::vector<Vec2> baseOf(const Block& block) {
  std::vector<Vec2> corners;
  for (const Vec2 s : {Vec2(-1, -1), Vec2(1, -1), Vec2(1, 1), Vec2(-1, 1)}) {
    const Vec3 corner = block.pose.position + block.pose.rotation * Vec3(s.x * block.half_m.x, s.y * block.half_m.y, 0);
    corners.emplace_back(corner.x, corner.y);
  }
  return corners;
}

/// Of convex polygons, both counterclockwise (Sutherland and Hodgman 1974).
std::vector<Vec2> shared(std::vector<Vec2> polygon, const std::vector<Vec2>& window) {
  for (std::size_t i = 0; i < window.size(); ++i) {
    const Vec2 from = window[i], side = window[(i + 1) % window.size()] - from;
    std::vector<Vec2> kept;
    for (std::size_t j = 0; j < polygon.size(); ++j) {
      const Vec2 a = polygon[j], b = polygon[(j + 1) % polygon.size()];
      const double inA = cross(side, a - from), inB = cross(side, b - from);
      if (inA >= 0) kept.push_back(a);
      if ((inA < 0) != (inB < 0)) kept.push_back(a + inA / (inA - inB) * (b - a));
    }
    polygon = std::move(kept);
  }
  return polygon;
}

bool isWellInside(const std::vector<Vec2>& polygon, Vec2 point) {
  if (polygon.size() < 3) return false;
  double nearest_m = std::numeric_limits<double>::infinity(), size_m = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 side = polygon[(i + 1) % polygon.size()] - polygon[i];
    const double length_m = glm::length(side);
    if (length_m > 0) nearest_m = std::min(nearest_m, cross(side, point - polygon[i]) / length_m);
    size_m = std::max(size_m, glm::distance(polygon[i], polygon[0]));
  }
  return nearest_m > kInner * size_m;
}

}  // namespace

namespace {

/// A ball's with a box, by the box's place that is nearest to the middle.
double overlapWithBox(const Block& ball, const Block& box) {
  const Vec3 at = glm::conjugate(box.pose.rotation) * (ball.pose.position - box.pose.position);
  const Vec3 beyond = glm::abs(at) - box.half_m;
  const double outside_m = glm::length(glm::max(beyond, Vec3(0)));
  return ball.radius_m() - (outside_m > 0 ? outside_m : std::max({beyond.x, beyond.y, beyond.z}));
}

}  // namespace

double overlapOf(const Block& a, const Block& b) {
  if (a.isBall && b.isBall) return a.radius_m() + b.radius_m() - glm::distance(a.pose.position, b.pose.position);
  if (a.isBall != b.isBall) return a.isBall ? overlapWithBox(a, b) : overlapWithBox(b, a);
  const std::array<Vec3, 3> axesA = axesOf(a), axesB = axesOf(b);
  const Vec3 between = b.pose.position - a.pose.position;
  double least_m = std::numeric_limits<double>::infinity();
  const auto part = [&](Vec3 axis) {
    least_m = std::min(least_m, reach(a, axesA, axis) + reach(b, axesB, axis) - std::abs(glm::dot(between, axis)));
  };
  for (const Vec3 axis : axesA) part(axis);
  for (const Vec3 axis : axesB) part(axis);
  for (const Vec3 u : axesA) {
    for (const Vec3 v : axesB) {
      const Vec3 axis = glm::cross(u, v);
      if (const double sine = glm::length(axis); sine > kParallel) part(axis / sine);
    }
  }
  return least_m;
}

bool stands(std::span<const Block> stack) {
  double mass_kg = 0;
  Vec2 moment(0);
  for (std::size_t i = stack.size() - 1; i > 0; --i) {
    mass_kg += stack[i].mass_kg;
    moment += stack[i].mass_kg * Vec2(stack[i].pose.position.x, stack[i].pose.position.y);
    if (!isWellInside(shared(baseOf(stack[i]), baseOf(stack[i - 1])), moment / mass_kg)) return false;
  }
  return true;
}

}  // namespace haptics::eval

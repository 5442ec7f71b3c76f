#include "haptic_server/engine/motion/solid.h"

#include <algorithm>
#include <vector>

#include "common/interruption/interruption.h"

namespace haptics {
namespace {

using Triangles = std::span<const std::array<std::uint32_t, 3>>;

/// A side from its lower to its higher vertex, and whether the triangle runs along it that way.
struct Side {
  std::uint64_t ends;
  int direction;
};

[[nodiscard]] std::uint64_t countOpenSides(Triangles triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (const auto& corners : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = corners[k];
      const std::uint64_t b = corners[(k + 1) % 3];
      sides.push_back({std::min(a, b) << 32U | std::max(a, b), a < b ? 1 : -1});
    }
  }
  interruptionPoint();
  std::ranges::sort(sides, [](const Side& a, const Side& b) {
    interruptionPoint();
    return a.ends < b.ends;
  });
  interruptionPoint();
  std::uint64_t open = 0;
  for (auto first = sides.begin(); first != sides.end();) {
    const auto last = std::find_if(first, sides.end(), [&](const Side& s) { return s.ends != first->ends; });
    std::int64_t sum = 0;
    for (; first != last; ++first) sum += first->direction;
    open += static_cast<std::uint64_t>(std::abs(sum));
  }
  return open;
}

/// Integrals over signed tetrahedra: of 1, of x, and of x x^T.
struct Moments {
  double volume = 0;
  Vec3 first{0};
  glm::dmat3 second{0};

  /// The tetrahedron of the origin and a triangle.
  void add(Vec3 a, Vec3 b, Vec3 c) {
    const double six = glm::dot(a, glm::cross(b, c));
    const Vec3 sum = a + b + c;
    volume += six / 6;
    first += six / 24 * sum;
    second +=
        six / 120 *
        (glm::outerProduct(a, a) + glm::outerProduct(b, b) + glm::outerProduct(c, c) + glm::outerProduct(sum, sum));
  }
};

}  // namespace

Solid solidOf(std::span<const Vec3f> vertices, Triangles triangles, bool sidesCancel) {
  Solid solid;
  solid.openSides = sidesCancel ? 0 : countOpenSides(triangles);
  if (solid.openSides > 0) solid.defect = SolidDefect::kOpen;
  if (solid.openSides > 0 || vertices.empty()) return solid;

  // A corner amid the mesh: far from it, the tetrahedra's volumes would cancel down to rounding.
  Vec3 lowest(vertices[0]);
  Vec3 highest(vertices[0]);
  for (const Vec3f v : vertices) {
    lowest = glm::min(lowest, Vec3(v));
    highest = glm::max(highest, Vec3(v));
  }
  const Vec3 corner = (lowest + highest) / 2.0;
  Moments moments;
  for (const auto& t : triangles) {
    interruptionPoint();
    moments.add(Vec3(vertices[t[0]]) - corner, Vec3(vertices[t[1]]) - corner, Vec3(vertices[t[2]]) - corner);
  }
  const double extent = glm::length(highest - lowest);
  // Fraction of the box's volume that rounding leaves: float vertices are exact to 2^-24 of the extent.
  constexpr double kNothing = 0x1p-24;
  if (!(std::abs(moments.volume) > kNothing * extent * extent * extent)) {
    solid.defect = SolidDefect::kFlat;
    return solid;
  }
  if (moments.volume < 0) solid.defect = SolidDefect::kInsideOut;

  const Vec3 middle = moments.first / moments.volume;
  const glm::dmat3 spread = moments.second - moments.volume * glm::outerProduct(middle, middle);
  solid.volume_m3 = moments.volume;
  solid.centre = corner + middle;
  solid.inertia = (spread[0][0] + spread[1][1] + spread[2][2]) * glm::dmat3(1) - spread;
  return solid;
}

}  // namespace haptics

#include "haptic_server/engine/tool/tool_shell.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "common/interruption/interruption.h"
#include "haptic_server/engine/geometry/spaced_points.h"

namespace haptics {
namespace {

/// Vertices are points as long as these are no more than so many in all, or so many beside those at the spacing. More make a
/// tool of fine triangles lag behind a fast hand; less leave corners out that others feel.
constexpr std::size_t kMaxWithVertices = 2'000, kMaxVertices = 1'000;

/// Fractions in [0, 1), the same for the same number (R2 sequence, Roberts 2018).
[[nodiscard]] std::array<double, 2> fractions(std::uint64_t number) {
  constexpr double kA = 0.7548776662466927, kB = 0.5698402909980532;
  const auto n = static_cast<double>(number);
  return {std::fmod(0.5 + n * kA, 1), std::fmod(0.5 + n * kB, 1)};
}

/// @return Are they, with the vertices that are farther than `apart` (m) from all before, no more than `most`?
[[nodiscard]] bool addVertices(const CollisionMesh& mesh, double apart, std::size_t most, std::vector<Vec3>& points) {
  SpacedPoints all(apart);
  for (const Vec3& point : points) all.add(point);
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) {
    interruptionPoint();
    for (int k = 0; k < 3; ++k) {
      const Vec3 vertex = mesh.triangle(t).corner(k);
      if (!all.add(vertex)) continue;
      if (points.size() >= most) return false;
      points.push_back(vertex);
    }
  }
  return true;
}

}  // namespace

Result<ToolShell> makeToolShell(const CollisionMesh& mesh, double spacing_m) {
  if (!(spacing_m > 0)) return refused("spacing_m", "is " + std::to_string(spacing_m) + "; it has to be positive");
  const auto tooMany = [] {
    return refused("spacing_m", "gives more than " + std::to_string(kMaxToolPoints) + " points; take a wider one");
  };
  SpacedPoints points(spacing_m);
  if (!addSharpPoints(mesh, spacing_m, kMaxToolPoints, points)) return tooMany();

  double area = 0;
  const std::uint32_t triangles = mesh.triangleCount();
  for (std::uint32_t t = 0; t < triangles; ++t) area += 0.5 * glm::length(mesh.triangle(t).areaNormal());
  const double wanted = dartsFor(area, spacing_m);
  if (!(wanted <= kMaxDarts)) return tooMany();
  double due = 0;
  std::uint64_t number = 0;
  std::vector<Vec3> darts;
  for (std::uint32_t t = 0; t < triangles; ++t) {
    interruptionPoint();
    const TriangleRecord& r = mesh.triangle(t);
    const Vec3 a = r.corner(0), b = r.corner(1), c = r.corner(2);
    for (due += wanted * 0.5 * glm::length(r.areaNormal()) / area; due >= 1; --due) {
      auto [u, v] = fractions(number++);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      darts.push_back(a + u * (b - a) + v * (c - a));
    }
  }
  // In an order that has nothing to do with that of the triangles: a neighbour is seldom next.
  const std::size_t count = darts.size();
  constexpr std::size_t kStride = 2'654'435'761;  // prime, and larger than any count
  for (std::size_t i = 0, at = 0; i < count; ++i, at = (at + kStride) % count) {
    interruptionPoint();
    points.add(darts[at]);
    if (points.size() > kMaxToolPoints) return tooMany();
  }
  if (points.size() == 0) points.add(mesh.triangle(0).corner(0));

  ToolShell shell{points.take()};
  shell.spaced = shell.points.size();
  shell.nearVertex_m = std::min(kNearVertex_m, spacing_m);
  const std::size_t most = std::min(std::max(kMaxWithVertices, shell.spaced + kMaxVertices), kMaxToolPoints);
  for (; !addVertices(mesh, shell.nearVertex_m, most, shell.points); shell.nearVertex_m *= 2)
    shell.points.resize(shell.spaced);
  for (const Vec3& point : shell.points) shell.radius_m = std::max(shell.radius_m, glm::length(point));
  return shell;
}

}  // namespace haptics

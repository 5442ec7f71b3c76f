#include "haptic_server/engine/tool/tool_shell.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

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

/// The part of a mesh that some of its triangles are.
struct MeshPart {
  std::vector<Vec3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// @return Upper and lower jaw.
[[nodiscard]] Result<std::array<MeshPart, 2>> divided(std::span<const Vec3f> vertices,
                                                      std::span<const std::array<std::uint32_t, 3>> triangles,
                                                      const JawHinge& hinge) {
  const Vec3 up = glm::cross(hinge.axis, hinge.reach);
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> numberInJaw(vertices.size(), kNone);
  std::array<MeshPart, 2> jaws;
  for (std::array<std::uint32_t, 3> triangle : triangles) {
    interruptionPoint();
    int above = 0;
    for (const std::uint32_t v : triangle) {
      const double height_m = glm::dot(up, Vec3(vertices[v]) - hinge.place_m);
      if (!(std::abs(height_m) >= kNearVertex_m)) {
        return refused("jaws",
                       "have vertex " + std::to_string(v) +
                           " on the plane between them, through `hinge_m` along `axis` and `reach`; leave a gap");
      }
      above += height_m > 0 ? 1 : 0;
    }
    if (above % 3 != 0) {
      return refused("jaws", "are joined by a triangle, of the vertices " + std::to_string(triangle[0]) + ", " +
                                 std::to_string(triangle[1]) + ", " + std::to_string(triangle[2]) +
                                 "; none may cross the plane through `hinge_m` along `axis` and `reach`");
    }
    MeshPart& jaw = jaws[above == 3 ? 0 : 1];
    for (std::uint32_t& v : triangle) {
      if (numberInJaw[v] == kNone) {
        numberInJaw[v] = static_cast<std::uint32_t>(jaw.vertices.size());
        jaw.vertices.push_back(vertices[v]);
      }
      v = numberInJaw[v];
    }
    jaw.triangles.push_back(triangle);
  }
  if (jaws[0].triangles.empty() || jaws[1].triangles.empty()) {
    return refused("jaws",
                   "are both on one side of the plane through `hinge_m` along `axis` and `reach`; they meet at it");
  }
  return jaws;
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

Result<Tool> makeJaws(std::span<const Vec3f> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
                      const JawHinge& hinge, double spacing_m) {
  const auto parts = divided(vertices, triangles, hinge);
  if (!parts) return tl::unexpected(parts.error());
  std::array<std::shared_ptr<const CollisionMesh>, 2> surface;
  std::array<ToolShell, 2> shell;
  for (std::size_t jaw = 0; jaw < 2; ++jaw) {
    surface[jaw] = buildCollisionMesh((*parts)[jaw].vertices, (*parts)[jaw].triangles);
    auto made = makeToolShell(*surface[jaw], spacing_m);
    if (!made) return tl::unexpected(std::move(made.error()));
    shell[jaw] = *std::move(made);
  }
  const auto& [upper, lower] = shell;
  if (upper.points.size() + lower.points.size() > kMaxToolPoints) {
    return refused("spacing_m",
                   "gives more than " + std::to_string(kMaxToolPoints) + " points of both jaws; take a wider one");
  }
  Tool tool{surface[0], upper};
  tool.shell.points.insert(tool.shell.points.end(), lower.points.begin(), lower.points.end());
  tool.shell.spaced += lower.spaced;
  tool.shell.nearVertex_m = std::max(upper.nearVertex_m, lower.nearVertex_m);
  for (const Vec3& point : tool.shell.points) {
    const double opened_m = glm::length(hinge.place_m) + glm::distance(hinge.place_m, point);
    tool.shell.radius_m = std::max(tool.shell.radius_m, opened_m);
  }
  tool.jaws = {hinge.place_m, hinge.axis, surface[1], upper.points.size()};
  return tool;
}

}  // namespace haptics

#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <numbers>
#include <unordered_map>
#include <utility>
#include <vector>

#include "haptic_server/engine/geometry/collision_mesh.h"

/// Meshes for the tests of geometry and contact: closed, consistently oriented, welded unless a name says otherwise;
/// metres.
namespace haptics::shapes {

struct Shape {
  std::vector<Vec3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  [[nodiscard]] std::shared_ptr<const CollisionMesh> build(int threads = 1) const {
    return buildCollisionMesh(vertices, triangles, threads);
  }
  [[nodiscard]] Vec3 corner(std::size_t t, std::size_t k) const { return Vec3(vertices[triangles[t][k]]); }
  void add(const Shape& other, Vec3 at = Vec3(0)) {
    const auto offset = static_cast<std::uint32_t>(vertices.size());
    for (const Vec3f v : other.vertices) vertices.push_back(v + Vec3f(at));
    for (const auto& t : other.triangles) triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  [[nodiscard]] Shape mapped(const std::function<Vec3(Vec3)>& map) const {
    Shape result = *this;
    for (Vec3f& v : result.vertices) v = Vec3f(map(Vec3(v)));
    return result;
  }
  [[nodiscard]] Shape scaled(double factor) const {
    return mapped([&](Vec3 v) { return v * factor; });
  }
};

/// The cube [-1, 1]^3 with n x n x 2 triangles to a side.
inline Shape cubeGrid(int n) {
  Shape shape;
  std::unordered_map<std::int64_t, std::uint32_t> known;
  known.reserve(static_cast<std::size_t>(6 * n * n + 2));
  const auto vertex = [&](std::array<int, 3> at) {
    const std::int64_t place = (std::int64_t{at[0]} * (n + 1) + at[1]) * (n + 1) + at[2];
    const auto [entry, added] = known.try_emplace(place, static_cast<std::uint32_t>(shape.vertices.size()));
    if (added) shape.vertices.emplace_back(Vec3(at[0], at[1], at[2]) * (2.0 / n) - Vec3(1));
    return entry->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const int end : {0, n}) {
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          const auto at = [&](int a, int b) {
            std::array<int, 3> p{};
            p[axis] = end;
            p[(axis + 1) % 3] = a;
            p[(axis + 2) % 3] = b;
            return vertex(p);
          };
          std::array<std::uint32_t, 4> q{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
          if (end == 0) std::swap(q[1], q[3]);
          const std::size_t turn = static_cast<std::size_t>((i + j) % 2);  // no direction is preferred
          for (const std::size_t k : {std::size_t{0}, std::size_t{2}}) {
            shape.triangles.push_back({q[(turn + k) % 4], q[(turn + k + 1) % 4], q[(turn + k + 2) % 4]});
          }
        }
      }
    }
  }
  return shape;
}

inline Shape box(Vec3 size, int n = 1) {
  return cubeGrid(n).mapped([&](Vec3 v) { return v * size * 0.5; });
}

/// 12 n^2 triangles.
inline Shape sphere(double radius, int n) {
  return cubeGrid(n).mapped([&](Vec3 v) { return glm::normalize(glm::tan(v * (std::numbers::pi / 4))) * radius; });
}

/// A sphere with hills and valleys of a tenth of its radius.
inline Shape bumpy(double radius, int n) {
  return sphere(1, n).mapped(
      [&](Vec3 v) { return v * radius * (1 + 0.1 * std::sin(9 * v.x) * std::sin(8 * v.y + 1) * std::cos(7 * v.z)); });
}

inline Shape torus(double major, double minor, int around, int across) {
  Shape shape;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / around;
      const double v = 2 * std::numbers::pi * j / across;
      const double r = major + minor * std::cos(v);
      shape.vertices.emplace_back(Vec3(r * std::cos(u), r * std::sin(u), minor * std::sin(v)));
    }
  }
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const auto at = [&](int a, int b) { return static_cast<std::uint32_t>(a % around * across + b % across); };
      const std::array<std::uint32_t, 4> q{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
      shape.triangles.push_back({q[0], q[1], q[2]});
      shape.triangles.push_back({q[0], q[2], q[3]});
    }
  }
  return shape;
}

/// A cone about z: apex up at (0, 0, height), `valence` triangles around it, closed below by a fan.
inline Shape cone(double radius, double height, int valence) {
  Shape shape;
  shape.vertices = {Vec3f(0, 0, static_cast<float>(height)), Vec3f(0)};
  const auto count = static_cast<std::uint32_t>(valence);
  for (std::uint32_t i = 0; i < count; ++i) {
    const double a = 2 * std::numbers::pi * i / valence;
    shape.vertices.emplace_back(Vec3(radius * std::cos(a), radius * std::sin(a), 0));
    shape.triangles.push_back({0, 2 + i, 2 + (i + 1) % count});
    shape.triangles.push_back({1, 2 + (i + 1) % count, 2 + i});
  }
  return shape;
}

/// A square sheet of side `size` in the plane z = 0, facing up, n x n x 2 triangles: open.
inline Shape sheet(double size, int n) {
  Shape shape;
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      shape.vertices.emplace_back(
          Vec3(size * (static_cast<double>(i) / n - 0.5), size * (static_cast<double>(j) / n - 0.5), 0));
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      shape.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      shape.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return shape;
}

/// A row of boxes along x, upright in z.
inline Shape comb(int teeth, double pitch, double tooth, double height, double depth) {
  Shape shape;
  for (int i = 0; i < teeth; ++i) {
    const Vec3 size{tooth, depth, height};
    shape.add(box(size), Vec3(pitch * (i - 0.5 * (teeth - 1)), 0, 0));
  }
  return shape;
}

}  // namespace haptics::shapes

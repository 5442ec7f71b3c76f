#include "tests/eval/table1/paper_objects.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "common/mesh/generators.h"
#include "common/mesh/import.h"

namespace haptics::eval {
namespace {

constexpr double kInnerRadius_m = 0.04;

/// Rings about z, one above the other, triangulated between each other.
struct RingStack {
  std::vector<std::uint32_t> sizes;  ///< Vertices of each ring; 1 is a pole.
  std::vector<TriangleIndices> triangles;

  explicit RingStack(std::vector<std::uint32_t> ringSizes) : sizes(std::move(ringSizes)) {
    std::uint32_t first = 0;
    for (std::size_t i = 0; i + 1 < sizes.size(); ++i) {
      join(first, sizes[i], first + sizes[i], sizes[i + 1]);
      first += sizes[i];
    }
  }
  /// On a sphere, from one polar angle to another (rad).
  [[nodiscard]] std::vector<Vec3> onSphere(double radius, double from, double to) const {
    std::vector<Vec3> places;
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      const double polar = from + (to - from) * static_cast<double>(i) / static_cast<double>(sizes.size() - 1);
      for (std::uint32_t k = 0; k < sizes[i]; ++k) {
        const double around = 2 * std::numbers::pi * k / sizes[i];
        places.push_back(Vec3(std::sin(polar) * Vec3(std::cos(around), std::sin(around), 0)) * radius +
                         Vec3(0, 0, radius * std::cos(polar)));
      }
    }
    return places;
  }

 private:
  /// Goes round both rings at once, each time on along the one that lags.
  void join(std::uint32_t a, std::uint32_t countA, std::uint32_t b, std::uint32_t countB) {
    std::uint32_t i = 0;
    std::uint32_t j = 0;
    while (i < countA || j < countB) {
      const bool onA = j == countB || (i < countA && (i + 0.5) * countB < (j + 0.5) * countA);
      const std::uint32_t atA = a + i % countA;
      const std::uint32_t atB = b + j % countB;
      if (onA) {
        const std::uint32_t next = a + (i + 1) % countA;
        if (countA > 1) triangles.push_back({atA, atB, next});
        ++i;
      } else {
        const std::uint32_t next = b + (j + 1) % countB;
        if (countB > 1) triangles.push_back({atA, atB, next});
        ++j;
      }
    }
  }
};

/// Ring sizes that swell from the ends to the middle and come to exactly `total` vertices.
std::vector<std::uint32_t> swelling(std::size_t rings, std::uint32_t ends, std::uint32_t total) {
  std::vector<std::uint32_t> sizes(rings, ends);
  std::uint32_t left = total - ends * static_cast<std::uint32_t>(rings);
  for (std::size_t margin = 1; left > 0; margin = margin + 1 < (rings + 1) / 2 ? margin + 1 : 1) {
    for (std::size_t i = margin; i + margin < rings && left > 0; ++i, --left) ++sizes[i];
  }
  return sizes;
}

TriMesh canonical(const std::vector<Vec3>& vertices, std::vector<TriangleIndices> triangles) {
  return canonicalise(vertices, std::move(triangles), {}).value().mesh;
}

constexpr double kCap_rad = 0.5;  // cut off at either end

TriMesh openBall() {
  const RingStack rings(swelling(14, 11, 239));
  return canonical(rings.onSphere(kTableRadius_m, kCap_rad, std::numbers::pi - kCap_rad), rings.triangles);
}

TriMesh ballOf180Rings() {
  std::vector<std::uint32_t> sizes(182, 180);
  sizes.front() = sizes.back() = 1;
  const RingStack rings(sizes);
  return canonical(rings.onSphere(kTableRadius_m, 0, std::numbers::pi), rings.triangles);
}

/// Triangles on the far side (x < 0) that share no vertex with each other.
std::vector<std::size_t> tunnelPlaces(const std::vector<Vec3>& vertices, const std::vector<TriangleIndices>& triangles,
                                      std::size_t count) {
  std::vector<bool> used(vertices.size());
  std::vector<std::size_t> places;
  for (std::size_t t = 0; t < triangles.size() && places.size() < count; ++t) {
    const bool free = std::all_of(triangles[t].begin(), triangles[t].end(), [&](std::uint32_t v) {
      return !used[v] && vertices[v].x < -0.2 * kTableRadius_m &&
             std::abs(vertices[v].z) < 0.7 * kTableRadius_m;  // away from the openings
    });
    if (!free) continue;
    for (const std::uint32_t v : triangles[t]) used[v] = true;
    places.push_back(t);
  }
  return places;
}

TriMesh ballsWithTunnels() {
  constexpr std::size_t kTunnels = 24;
  const RingStack rings(swelling(14, 25, 451));
  std::vector<Vec3> vertices = rings.onSphere(kTableRadius_m, kCap_rad, std::numbers::pi - kCap_rad);
  const auto inner = static_cast<std::uint32_t>(vertices.size());
  const std::vector<std::size_t> tunnels = tunnelPlaces(vertices, rings.triangles, kTunnels);
  for (const Vec3 v : rings.onSphere(kInnerRadius_m, kCap_rad, std::numbers::pi - kCap_rad)) vertices.push_back(v);
  std::vector<TriangleIndices> triangles;
  for (std::size_t t = 0; t < rings.triangles.size(); ++t) {
    const TriangleIndices& v = rings.triangles[t];
    if (std::find(tunnels.begin(), tunnels.end(), t) == tunnels.end()) {
      triangles.push_back(v);
      triangles.push_back({v[2] + inner, v[1] + inner, v[0] + inner});
      continue;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = v[k];
      const std::uint32_t b = v[(k + 1) % 3];
      triangles.push_back({a, b, b + inner});
      triangles.push_back({a, b + inner, a + inner});
    }
  }
  return canonical(vertices, std::move(triangles));
}

void mustHave(const TableObject& object, const MeshCounts& counts) {
  if (countsOf(object.mesh) != counts) throw std::logic_error(std::string(object.name) + " has not the paper's counts");
}

}  // namespace

MeshCounts countsOf(const TriMesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> lines;
  lines.reserve(3 * mesh.triangles.size());
  for (const TriangleIndices& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) lines.push_back(std::minmax(t[k], t[(k + 1) % 3]));
  }
  std::sort(lines.begin(), lines.end());
  MeshCounts counts{mesh.vertices.size(), 0, mesh.triangles.size(), 0};
  for (auto at = lines.begin(); at != lines.end();) {
    const auto next = std::upper_bound(at, lines.end(), *at);
    ++counts.lines;
    counts.boundaryLines += next - at == 1 ? 1 : 0;
    at = next;
  }
  return counts;
}

double tablePathHeight_m() {
  const double radius = kTableRadius_m - kTableDepth_m;
  return std::sqrt(radius * radius - kTablePathRadius_m * kTablePathRadius_m);
}

std::vector<TableObject> tableObjects(int finest) {
  const double side = 2 * (tablePathHeight_m() + kTableDepth_m);
  std::vector<TableObject> objects;
  objects.push_back({"object 1", 12, 13, makeBox(Vec3(side), 1).value()});
  mustHave(objects.back(), {8, 18, 12, 0});
  objects.push_back({"object 2", 11, 12, openBall()});
  mustHave(objects.back(), {239, 695, 456, 22});
  objects.push_back({"object 3", 11, 12, ballsWithTunnels()});
  mustHave(objects.back(), {902, 2750, 1800, 100});
  objects.push_back({"object 4", 9, 10, ballOf180Rings()});
  mustHave(objects.back(), {32402, 97200, 64800, 0});
  for (const auto& [name, segments] : {std::pair{"sphere, 1 million", 289}, {"sphere, 10 million", 913}}) {
    if (12 * segments * segments > finest) break;
    objects.push_back({name, 0, 0, makeSphere(kTableRadius_m, static_cast<std::uint32_t>(segments)).value()});
  }
  return objects;
}

}  // namespace haptics::eval

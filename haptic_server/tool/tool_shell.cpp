#include "haptic_server/tool/tool_shell.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>

namespace haptics {
namespace {

/// Darts for each disk of the spacing: fewer leave holes, more take time.
constexpr double kDartsPerDisk = 32;
constexpr std::size_t kMaxDarts = 4'000'000;

/// Places no two of which are nearer than the spacing.
class Disks {
 public:
  explicit Disks(double spacing_m) : spacing_(spacing_m) {}

  [[nodiscard]] bool hasRoomAt(Vec3 place) const {
    const auto [x, y, z] = cellOf(place);
    for (std::int64_t i = x - 1; i <= x + 1; ++i) {
      for (std::int64_t j = y - 1; j <= y + 1; ++j) {
        for (std::int64_t k = z - 1; k <= z + 1; ++k) {
          const auto [first, last] = cells_.equal_range(keyOf({i, j, k}));
          for (auto at = first; at != last; ++at) {
            if (squaredLength(points_[at->second] - place) < spacing_ * spacing_) return false;
          }
        }
      }
    }
    return true;
  }
  void add(Vec3 place) {
    cells_.emplace(keyOf(cellOf(place)), points_.size());
    points_.push_back(place);
  }
  [[nodiscard]] std::vector<Vec3>& points() { return points_; }

 private:
  using Cell = std::array<std::int64_t, 3>;
  double spacing_;
  std::vector<Vec3> points_;
  std::unordered_multimap<std::uint64_t, std::size_t> cells_;

  [[nodiscard]] Cell cellOf(Vec3 place) const {
    const auto along = [&](double x) { return static_cast<std::int64_t>(std::floor(x / spacing_)); };
    return {along(place.x), along(place.y), along(place.z)};
  }
  /// Cells that share a key are only looked at in vain.
  [[nodiscard]] static std::uint64_t keyOf(const Cell& cell) {
    std::uint64_t key = 0;
    for (const std::int64_t c : cell) key = (key ^ static_cast<std::uint64_t>(c)) * 0x9e3779b97f4a7c15ULL;
    return key;
  }
};

struct Line {
  std::uint32_t a, b;
};

[[nodiscard]] Vec3 areaNormal(const TriMesh& mesh, const TriangleIndices& t) {
  const Vec3 a(mesh.vertices[t[0]]), b(mesh.vertices[t[1]]), c(mesh.vertices[t[2]]);
  return glm::cross(b - a, c - a);
}

/// Lines that bend by more than kSharp_rad, and those at which no two triangles meet.
[[nodiscard]] std::vector<Line> sharpLines(const TriMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Vec3>> normals;
  for (const TriangleIndices& t : mesh.triangles) {
    const Vec3 normal = glm::normalize(areaNormal(mesh, t));
    for (std::size_t k = 0; k < 3; ++k) normals[std::minmax(t[k], t[(k + 1) % 3])].push_back(normal);
  }
  std::vector<Line> sharp;
  for (const auto& [ends, of] : normals) {
    if (of.size() != 2 || glm::dot(of[0], of[1]) < std::cos(kSharp_rad)) sharp.push_back({ends.first, ends.second});
  }
  return sharp;
}

/// Fractions in [0, 1), the same for the same number (R2 sequence, Roberts 2018).
[[nodiscard]] std::array<double, 2> fractions(std::uint64_t number) {
  constexpr double kA = 0.7548776662466927, kB = 0.5698402909980532;
  const auto n = static_cast<double>(number);
  return {std::fmod(0.5 + n * kA, 1), std::fmod(0.5 + n * kB, 1)};
}

}  // namespace

Result<ToolShell> makeToolShell(const TriMesh& mesh, double spacing_m) {
  if (!(spacing_m > 0)) return refused("spacing_m", "is " + std::to_string(spacing_m) + "; it has to be positive");
  const auto refuseCount = [&](std::size_t points) {
    return refused("spacing_m", "gives more than " + std::to_string(points) + " points; at most " +
                                    std::to_string(kMaxToolPoints) + " are followed: take a wider one");
  };
  Disks disks(spacing_m);
  const std::vector<Line> sharp = sharpLines(mesh);
  for (const Line& line : sharp) {
    for (const std::uint32_t v : {line.a, line.b}) {
      const Vec3 place(mesh.vertices[v]);
      if (disks.hasRoomAt(place)) disks.add(place);
      if (disks.points().size() > kMaxToolPoints) return refuseCount(kMaxToolPoints);
    }
  }
  for (const Line& line : sharp) {
    const Vec3 a(mesh.vertices[line.a]), b(mesh.vertices[line.b]);
    const double parts = std::floor(glm::distance(a, b) / spacing_m);
    if (parts > static_cast<double>(kMaxToolPoints)) return refuseCount(kMaxToolPoints);
    for (double part = 1; part < parts; ++part) {
      const Vec3 place = glm::mix(a, b, part / parts);
      if (disks.hasRoomAt(place)) disks.add(place);
    }
    if (disks.points().size() > kMaxToolPoints) return refuseCount(kMaxToolPoints);
  }

  double area = 0;
  for (const TriangleIndices& t : mesh.triangles) area += 0.5 * glm::length(areaNormal(mesh, t));
  const double wanted = kDartsPerDisk * area / (spacing_m * spacing_m);
  if (!(wanted <= static_cast<double>(kMaxDarts))) return refuseCount(kMaxToolPoints);
  double due = 0;
  std::uint64_t number = 0;
  std::vector<Vec3> darts;
  for (const TriangleIndices& t : mesh.triangles) {
    const Vec3 a(mesh.vertices[t[0]]), b(mesh.vertices[t[1]]), c(mesh.vertices[t[2]]);
    for (due += wanted * 0.5 * glm::length(areaNormal(mesh, t)) / area; due >= 1; --due) {
      auto [u, v] = fractions(number++);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      darts.push_back(a + u * (b - a) + v * (c - a));
    }
  }
  // In an order that has nothing to do with that of the triangles: a neighbour is seldom next.
  const std::size_t count = darts.size();
  constexpr std::size_t kStride = 2'654'435'761;  // prime, and larger than any count
  for (std::size_t i = 0, at = 0; i < count; ++i, at = (at + kStride) % count) {
    if (!disks.hasRoomAt(darts[at])) continue;
    disks.add(darts[at]);
    if (disks.points().size() > kMaxToolPoints) return refuseCount(kMaxToolPoints);
  }
  if (disks.points().empty()) disks.add(Vec3(mesh.vertices.front()));

  ToolShell shell{std::move(disks.points())};
  for (const Vec3& point : shell.points) shell.radius_m = std::max(shell.radius_m, glm::length(point));
  return shell;
}

}  // namespace haptics

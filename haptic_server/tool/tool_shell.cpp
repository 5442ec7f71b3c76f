#include "haptic_server/tool/tool_shell.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
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
  Vec3 a, b;
};

/// Lines that bend by more than kSharp_rad, and those at which no two triangles meet; each once.
[[nodiscard]] std::vector<Line> sharpLines(const CollisionMesh& mesh) {
  std::vector<Line> sharp;
  const double minCosine = std::cos(kSharp_rad);
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t other = mesh.triangle(t).neighbour(k);
      const bool joined = other != kNoTriangle;
      if (joined && (other < t || glm::dot(mesh.faceNormal(t), mesh.faceNormal(other)) >= minCosine)) continue;
      sharp.push_back({mesh.triangle(t).corner(k), mesh.triangle(t).corner(nextCorner(k))});
    }
  }
  return sharp;
}

/// The ends of the lines first, then places along them. False: there are too many.
[[nodiscard]] bool addAlong(const std::vector<Line>& lines, double spacing_m, Disks& disks) {
  const auto add = [&](Vec3 place) {
    if (disks.hasRoomAt(place)) disks.add(place);
    return disks.points().size() <= kMaxToolPoints;
  };
  for (const Line& line : lines) {
    if (!add(line.a) || !add(line.b)) return false;
  }
  for (const Line& line : lines) {
    const double parts = std::floor(glm::distance(line.a, line.b) / spacing_m);
    if (parts > static_cast<double>(kMaxToolPoints)) return false;
    for (double part = 1; part < parts; ++part) {
      if (!add(glm::mix(line.a, line.b, part / parts))) return false;
    }
  }
  return true;
}

/// Fractions in [0, 1), the same for the same number (R2 sequence, Roberts 2018).
[[nodiscard]] std::array<double, 2> fractions(std::uint64_t number) {
  constexpr double kA = 0.7548776662466927, kB = 0.5698402909980532;
  const auto n = static_cast<double>(number);
  return {std::fmod(0.5 + n * kA, 1), std::fmod(0.5 + n * kB, 1)};
}

}  // namespace

std::vector<Vec3> sharpPoints(const CollisionMesh& mesh, double spacing_m) {
  const std::vector<Line> lines = sharpLines(mesh);
  for (double spacing = spacing_m;; spacing *= 2) {
    Disks disks(spacing);
    if (addAlong(lines, spacing, disks)) return std::move(disks.points());
  }
}

Result<ToolShell> makeToolShell(const CollisionMesh& mesh, double spacing_m) {
  if (!(spacing_m > 0)) return refused("spacing_m", "is " + std::to_string(spacing_m) + "; it has to be positive");
  const auto tooMany = [] {
    return refused("spacing_m", "gives more than " + std::to_string(kMaxToolPoints) + " points; take a wider one");
  };
  Disks disks(spacing_m);
  if (!addAlong(sharpLines(mesh), spacing_m, disks)) return tooMany();

  double area = 0;
  const std::uint32_t triangles = mesh.triangleCount();
  for (std::uint32_t t = 0; t < triangles; ++t) area += 0.5 * glm::length(mesh.triangle(t).areaNormal());
  const double wanted = kDartsPerDisk * area / (spacing_m * spacing_m);
  if (!(wanted <= static_cast<double>(kMaxDarts))) return tooMany();
  double due = 0;
  std::uint64_t number = 0;
  std::vector<Vec3> darts;
  for (std::uint32_t t = 0; t < triangles; ++t) {
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
    if (!disks.hasRoomAt(darts[at])) continue;
    disks.add(darts[at]);
    if (disks.points().size() > kMaxToolPoints) return tooMany();
  }
  if (disks.points().empty()) disks.add(mesh.triangle(0).corner(0));

  ToolShell shell{std::move(disks.points())};
  for (const Vec3& point : shell.points) shell.radius_m = std::max(shell.radius_m, glm::length(point));
  return shell;
}

}  // namespace haptics

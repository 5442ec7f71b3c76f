#include "haptic_server/engine/geometry/spaced_points.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/interruption/grow.h"
#include "common/maths/elementary.h"

namespace haptics {
namespace {

/// Cells that share a key are only looked at in vain.
[[nodiscard]] std::uint64_t keyOf(const std::array<std::int64_t, 3>& cell) {
  std::uint64_t key = 0;
  for (const std::int64_t c : cell) key = (key ^ static_cast<std::uint64_t>(c)) * 0x9e3779b97f4a7c15ULL;
  return key;
}

struct Line {
  Vec3 a, b;
};

/// Each once.
[[nodiscard]] std::vector<Line> sharpLines(const CollisionMesh& mesh) {
  std::vector<Line> sharp;
  const double minCosine = elementary::cos(kSharp_rad);
  forEach(mesh.triangleCount(), [&](std::size_t i) {
    const auto t = static_cast<std::uint32_t>(i);
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t other = mesh.triangle(t).neighbour(k);
      const bool joined = other != kNoTriangle;
      if (joined && (other < t || glm::dot(mesh.faceNormal(t), mesh.faceNormal(other)) >= minCosine)) continue;
      sharp.push_back({mesh.triangle(t).corner(k), mesh.triangle(t).corner(nextCorner(k))});
    }
  });
  return sharp;
}

}  // namespace

bool SpacedPoints::add(Vec3 place) {
  if (!hasRoomAt(place)) return false;
  cells_.emplace(keyOf(cellOf(place)), points_.size());
  points_.push_back(place);
  return true;
}

bool SpacedPoints::hasRoomAt(Vec3 place) const {
  const auto isFreeIn = [&](const Cell& cell) {
    const auto [first, last] = cells_.equal_range(keyOf(cell));
    return std::none_of(first, last, [&](const auto& known) {
      return squaredLength(points_[known.second] - place) < spacing_ * spacing_;
    });
  };
  const Cell own = cellOf(place);
  if (!isFreeIn(own)) return false;  // what is there already is found at once
  const auto [x, y, z] = own;
  for (std::int64_t i = x - 1; i <= x + 1; ++i) {
    for (std::int64_t j = y - 1; j <= y + 1; ++j) {
      for (std::int64_t k = z - 1; k <= z + 1; ++k) {
        if (!isFreeIn({i, j, k})) return false;
      }
    }
  }
  return true;
}

SpacedPoints::Cell SpacedPoints::cellOf(Vec3 place) const {
  constexpr double kFarthest = 0x1p60;  // cells: those beyond are one
  const auto along = [&](double x) {
    return static_cast<std::int64_t>(std::clamp(std::floor(x / spacing_), -kFarthest, kFarthest));
  };
  return {along(place.x), along(place.y), along(place.z)};
}

bool addSharpPoints(const CollisionMesh& mesh, double spacing_m, std::size_t max, SpacedPoints& points) {
  const std::vector<Line> lines = sharpLines(mesh);
  const auto add = [&](Vec3 place) {
    points.add(place);
    return points.size() <= max;
  };
  for (const Line& line : lines) {
    interruptionPoint();
    if (!add(line.a) || !add(line.b)) return false;
  }
  for (const Line& line : lines) {
    interruptionPoint();
    const double parts = std::floor(glm::distance(line.a, line.b) / spacing_m);
    if (parts > static_cast<double>(max)) return false;
    for (double part = 1; part < parts; ++part) {
      if (!add(glm::mix(line.a, line.b, part / parts))) return false;
    }
  }
  return true;
}

std::vector<Vec3> sharpPoints(const CollisionMesh& mesh, double spacing_m, std::size_t max) {
  for (double spacing = spacing_m;; spacing *= 2) {
    SpacedPoints points(spacing);
    if (addSharpPoints(mesh, spacing, max, points)) return points.take();
  }
}

}  // namespace haptics

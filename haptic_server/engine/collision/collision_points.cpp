#include "haptic_server/engine/collision/collision_points.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <span>
#include <utility>

#include "common/interruption/interruption.h"
#include "common/maths/elementary.h"
#include "haptic_server/engine/geometry/spaced_points.h"

namespace haptics {
namespace {

/// Faces that meet at less than this, rad, are one flat part.
constexpr double kFlat_rad = 1e-3;
constexpr std::size_t kPointsOfLeaf = 4;

/// Vertices at lines that bend, and are not sharp.
void addRoundVertices(const CollisionMesh& mesh, SpacedPoints& points) {
  const double flat = elementary::cos(kFlat_rad), sharp = elementary::cos(kSharp_rad);
  for (std::uint32_t t = 0; t < mesh.triangleCount() && points.size() <= kMaxCollisionPoints; ++t) {
    interruptionPoint();
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t other = mesh.triangle(t).neighbour(k);
      if (other == kNoTriangle || other < t) continue;
      const double cosine = glm::dot(mesh.faceNormal(t), mesh.faceNormal(other));
      if (cosine >= flat || cosine < sharp) continue;
      points.add(mesh.triangle(t).corner(k));
      points.add(mesh.triangle(t).corner(nextCorner(k)));
    }
  }
}

/// The mean of the normals of all faces at a place.
[[nodiscard]] Vec3 normalAt(const CollisionMesh& mesh, Vec3 place) {
  const double near = 1e-9 * (mesh.radius_m() + glm::length(place));
  Vec3 sum(0);
  std::vector<Vec3> seen;
  Allowance endless;
  mesh.hierarchy().visitNear(
      place, endless,
      [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t t = begin; t < end; ++t) {
          if (closestOn(mesh.triangle(t), t, place).squaredDistance > near * near) continue;
          const Vec3 normal = mesh.faceNormal(t);  // once for all triangles of one flat part
          if (std::ranges::any_of(seen, [&](const Vec3& n) { return glm::dot(n, normal) > 1 - 1e-9; })) continue;
          seen.push_back(normal);
          sum += normal;
        }
        return near * near;
      },
      near * near);
  const double length = glm::length(sum);
  return length > 0 ? sum / length : Vec3(0);
}

[[nodiscard]] std::vector<CollisionPoints::Point> withNormals(const CollisionMesh& mesh,
                                                              const std::vector<Vec3>& places) {
  std::vector<CollisionPoints::Point> points;
  points.reserve(places.size());
  for (const Vec3& place : places) {
    interruptionPoint();
    points.push_back({place, normalAt(mesh, place)});
  }
  return points;
}

[[nodiscard]] std::vector<Vec3> placesOf(const CollisionMesh& mesh) {
  for (double scale = mesh.radius_m();; scale *= 2) {
    SpacedPoints sharp(kSharpSpacing * scale), round(kRoundSpacing * scale);
    if (!addSharpPoints(mesh, kSharpSpacing * scale, kMaxCollisionPoints, sharp)) continue;
    addRoundVertices(mesh, round);
    if (sharp.size() + round.size() > kMaxCollisionPoints) continue;
    std::vector<Vec3> places = sharp.take();
    std::ranges::copy(round.take(), std::back_inserter(places));
    if (places.empty()) places.push_back(mesh.triangle(0).corner(0));
    return places;
  }
}

/// Halves the points along the longest side of their box, and so on.
class TreeBuilder {
 public:
  explicit TreeBuilder(CollisionPoints& made) : made_(made) {}

  void add(std::uint32_t begin, std::uint32_t end) {
    const auto points = std::span(made_.points).subspan(begin, end - begin);
    Vec3 low = points[0].place, high = low;
    for (const auto& p : points) {
      low = glm::min(low, p.place);
      high = glm::max(high, p.place);
    }
    CollisionPoints::Node node{(low + high) * 0.5, 0, begin, end, 0};
    for (const auto& p : points) node.radius_m = std::max(node.radius_m, glm::distance(p.place, node.centre));
    const std::size_t at = made_.nodes.size();
    made_.nodes.push_back(node);
    if (points.size() > kPointsOfLeaf) {
      const Vec3 size = high - low;
      const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
      const std::uint32_t middle = begin + (end - begin) / 2;
      std::ranges::nth_element(points, points.begin() + (middle - begin), [axis](const auto& one, const auto& other) {
        const Vec3 &a = one.place, &b = other.place;
        return std::array{a[axis], a.x, a.y, a.z} < std::array{b[axis], b.x, b.y, b.z};
      });
      add(begin, middle);
      add(middle, end);
    }
    made_.nodes[at].next = static_cast<std::uint32_t>(made_.nodes.size());
  }

 private:
  CollisionPoints& made_;
};

}  // namespace

CollisionPoints makeCollisionPoints(const CollisionMesh& mesh) {
  CollisionPoints made;
  made.points = withNormals(mesh, placesOf(mesh));
  TreeBuilder(made).add(0, static_cast<std::uint32_t>(made.points.size()));
  made.polytope = polytopeOf(mesh);
  if (!made.polytope) made.polytope = hullOf(mesh);
  return made;
}

}  // namespace haptics

#include "common/mesh/patch.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <unordered_set>
#include <utility>

#include "common/mesh/triangle_distance.h"

namespace haptics {
namespace {

using Side = std::pair<std::uint32_t, std::uint32_t>;

bool names(const TriangleIndices& triangle, std::uint32_t vertex) {
  return std::find(triangle.begin(), triangle.end(), vertex) != triangle.end();
}

bool holds(const Numbers& numbers, std::uint32_t n) { return std::binary_search(numbers.begin(), numbers.end(), n); }

/// The normal of the triangle that is not cut and runs along the side the other way.
std::optional<Vec3> normalBeside(const TriMesh& mesh, const Fans& fans, const Numbers& cut, Side side) {
  for (const std::uint32_t t : fans.of(side.first)) {
    const TriangleIndices& triangle = mesh.triangles[t];
    if (holds(cut, t) || !names(triangle, side.second)) continue;
    return areaNormal(
        {Vec3(mesh.vertices[triangle[0]]), Vec3(mesh.vertices[triangle[1]]), Vec3(mesh.vertices[triangle[2]])});
  }
  return std::nullopt;
}

}  // namespace

void makeUnique(Numbers& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

Fans::Fans(const TriMesh& mesh) : begin_(mesh.vertices.size() + 1, 0), triangles_(3 * mesh.triangles.size()) {
  for (const TriangleIndices& triangle : mesh.triangles) {
    for (const std::uint32_t v : triangle) ++begin_[v + 1];
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) triangles_[next[v]++] = t;
  }
}

std::optional<Numbers> Fans::around(const Numbers& vertices, std::size_t most, Work& work) const {
  std::size_t sides = 0;  // a triangle has three vertices
  for (const std::uint32_t v : vertices) sides += of(v).size();
  if (sides > 3 * most || !work.spend(12 * sides)) return std::nullopt;
  Numbers triangles;
  for (const std::uint32_t v : vertices) {
    const auto fan = of(v);
    triangles.insert(triangles.end(), fan.begin(), fan.end());
  }
  makeUnique(triangles);
  return triangles.size() > most ? std::nullopt : std::optional(std::move(triangles));
}

std::optional<std::vector<Rim>> rimsOf(const TriMesh& mesh, const Fans& fans, const Numbers& cut, Work& work) {
  if (!work.spend(96 * cut.size())) return std::nullopt;
  std::vector<Side> sides;
  for (const std::uint32_t t : cut) {
    const auto [a, b, c] = mesh.triangles[t];
    sides.insert(sides.end(), {{a, b}, {b, c}, {c, a}});
  }
  std::sort(sides.begin(), sides.end());
  std::map<std::uint32_t, std::uint32_t> next;
  for (const auto& [a, b] : sides) {
    if (std::binary_search(sides.begin(), sides.end(), Side{b, a})) continue;
    if (!next.emplace(a, b).second) return std::nullopt;  // rims touch
  }
  std::vector<Rim> rims;
  while (!next.empty()) {
    Rim rim;
    for (auto at = next.begin(); at != next.end(); at = next.find(rim.corners.back())) {
      const bool isLong = rim.beside.size() == kMaxCorners;
      if (isLong || !work.spend(32 + 4 * fans.of(at->first).size())) return std::nullopt;
      const auto beside = normalBeside(mesh, fans, cut, *at);
      if (!beside) return std::nullopt;
      rim.beside.push_back(*beside);
      if (rim.corners.empty()) rim.corners.push_back(at->first);
      rim.corners.push_back(at->second);
      next.erase(at);
    }
    if (rim.corners.front() != rim.corners.back()) return std::nullopt;
    rim.corners.pop_back();
    rims.push_back(std::move(rim));
  }
  return rims.empty() ? std::nullopt : std::optional(std::move(rims));
}

Numbers islandIn(const TriMesh& mesh, const Fans& fans, const Numbers& cut, std::span<const Rim> rims, std::size_t rim,
                 Work& work) {
  constexpr std::size_t kLarge = 8192;  // vertices that are none
  Numbers others;                       // a vertex of each rim that was not come to
  for (const Rim& other : rims) others.push_back(other.corners.front());
  makeUnique(others);
  std::unordered_set<std::uint32_t> seen;
  Numbers queue;
  Numbers triangles;
  const auto come = [&](std::uint32_t v) {
    if (!seen.insert(v).second) return;
    queue.push_back(v);
    if (holds(others, v)) std::erase(others, v);
  };
  come(rims[rim].corners.front());
  for (std::size_t next = 0; next < queue.size(); ++next) {
    const auto fan = fans.of(queue[next]);
    if (others.empty() || seen.size() >= kLarge || !work.spend(16 * fan.size())) return {};
    for (const std::uint32_t t : fan) {
      if (holds(cut, t)) continue;
      triangles.push_back(t);
      for (const std::uint32_t v : mesh.triangles[t]) come(v);
    }
  }
  if (others.empty()) return {};
  makeUnique(triangles);
  return triangles;
}

bool joinsOutside(const Fans& fans, const TriMesh& mesh, const Numbers& cut, std::uint32_t a, std::uint32_t b,
                  Work& work) {
  const auto fan = fans.of(a);
  work.spend(2 * fan.size());
  return std::any_of(fan.begin(), fan.end(),
                     [&](std::uint32_t t) { return names(mesh.triangles[t], b) && !holds(cut, t); });
}

Patch patchOf(const std::vector<Vec3f>& vertices, std::span<const TriangleIndices> triangles) {
  Patch patch;
  for (const auto [a, b, c] : triangles) patch.push_back({Vec3(vertices[a]), Vec3(vertices[b]), Vec3(vertices[c])});
  return patch;
}

double areaOf(const Patch& patch) {
  double area = 0;
  for (const auto& t : patch) area += glm::length(areaNormal(t)) / 2;
  return area;
}

double volumeUnder(const Patch& patch) {
  double volume = 0;
  for (const auto& t : patch) volume += glm::dot(t[0], glm::cross(t[1], t[2])) / 6;
  return volume;
}

std::optional<double> farthestFrom(const Patch& patch, const Patch& other, Work& work) {
  constexpr std::size_t kEach = 12;  // units for a distance
  double farthest2 = 0;
  std::size_t first = 0;  // the one that was near the last place is near the next one
  for (const auto& t : patch) {
    for (const Vec3 place : {t[0], t[1], t[2], (t[0] + t[1] + t[2]) / 3.0}) {
      double nearest2 = std::numeric_limits<double>::infinity();
      std::size_t nearest = first;
      std::size_t seen = 0;
      for (; seen < other.size() && nearest2 > farthest2; ++seen) {
        const std::size_t i = (first + seen) % other.size();
        const double distance2 = squaredDistance(place, other[i]);
        if (distance2 < nearest2) nearest = i;
        nearest2 = std::min(nearest2, distance2);
      }
      if (!work.spend(kEach * seen)) return std::nullopt;
      farthest2 = std::max(farthest2, nearest2);
      first = nearest;
    }
  }
  return std::sqrt(farthest2);
}

}  // namespace haptics

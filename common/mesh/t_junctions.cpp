#include "common/mesh/t_junctions.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/mesh/box_tree.h"

namespace haptics {
namespace {

/// Of the extent: 16 times the rounding of a float coordinate. Larger takes near misses for junctions.
constexpr double kOn = 0x1p-20;

struct Edge {
  Vec3 from, to;
};

bool comesNear(const Edge& edge, const Box& box, double near_m) {
  double enter = 0;
  double leave = 1;
  for (int d = 0; d < 3; ++d) {
    const double before = box.low[d] - near_m - edge.from[d], beyond = box.high[d] + near_m - edge.from[d];
    const double way = edge.to[d] - edge.from[d];
    if (way == 0) {
      if (before > 0 || beyond < 0) return false;
      continue;
    }
    enter = std::max(enter, std::min(before / way, beyond / way));
    leave = std::min(leave, std::max(before / way, beyond / way));
  }
  return enter <= leave;
}

bool liesOn(Vec3 place, const Edge& edge, double near_m) {
  const Vec3 along = edge.to - edge.from;
  const double time = glm::dot(place - edge.from, along) / squaredLength(along);
  if (!(time > 0 && time < 1)) return false;
  const double near2 = near_m * near_m;
  return squaredLength(edge.from + along * time - place) <= near2 && squaredLength(place - edge.from) > near2 &&
         squaredLength(place - edge.to) > near2;
}

/// Is any(item) for one of the items in leaves to which the edge comes near?
template <class Any>
bool anyNear(const BoxTree& tree, const Edge& edge, double near_m, Work& work, Any any) {
  std::array<std::size_t, 64> stack;
  std::size_t top = 0;
  stack[top++] = BoxTree::kRoot;
  while (top > 0 && work.spend(2)) {
    const std::size_t node = stack[--top];
    if (!comesNear(edge, tree.box(node), near_m)) continue;
    if (!tree.isLeaf(node)) {
      stack[top++] = 2 * node;
      stack[top++] = 2 * node + 1;
      continue;
    }
    work.spend(3 * BoxTree::kMostInLeaf);
    if (std::ranges::any_of(tree.leaf(node), any)) return true;
  }
  return false;
}

}  // namespace

std::optional<std::uint64_t> countTJunctions(const std::vector<Vec3f>& vertices,
                                             const std::vector<EdgeIndices>& boundary, Work& work) {
  std::vector<std::uint32_t> ends;
  for (const EdgeIndices& edge : boundary) ends.insert(ends.end(), edge.begin(), edge.end());
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  const BoxTree tree(static_cast<std::uint32_t>(ends.size()), [&](std::uint32_t end) {
    const Vec3f at = vertices[ends[end]];
    return Box{at, at};
  });
  const Box& all = tree.box(BoxTree::kRoot);
  const double near_m = kOn * std::max(glm::length(Vec3(all.low)), glm::length(Vec3(all.high)));

  std::uint64_t count = 0;
  for (const auto& [a, b] : boundary) {
    const Edge edge{Vec3(vertices[a]), Vec3(vertices[b])};
    const auto isOn = [&, a = a, b = b](std::uint32_t end) {
      const std::uint32_t v = ends[end];
      return v != a && v != b && liesOn(Vec3(vertices[v]), edge, near_m);
    };
    if (anyNear(tree, edge, near_m, work, isOn)) ++count;
    if (work.isOver()) return std::nullopt;
  }
  return count;
}

}  // namespace haptics

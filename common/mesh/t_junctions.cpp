#include "common/mesh/t_junctions.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/mesh/box_tree.h"

namespace haptics {
namespace {

/// Fraction of the extent: 16 times the rounding of a float coordinate. Larger takes near misses for junctions.
constexpr double kOn = 0x1p-20;

/// An edge, and the inverses of its length along each axis and of its squared length.
class Edge {
 public:
  Edge(Vec3 from, Vec3 to, double near_m)
      : from_(from), to_(to), perWay_(1.0 / (to - from)), perLength2_(1 / squaredLength(to - from)), near_m_(near_m) {}

  [[nodiscard]] bool comesNear(const Box& box) const {
    double enter = 0;
    double leave = 1;
    for (int d = 0; d < 3; ++d) {
      const double before = box.low[d] - near_m_ - from_[d], beyond = box.high[d] + near_m_ - from_[d];
      if (std::isinf(perWay_[d])) {
        if (before > 0 || beyond < 0) return false;
        continue;
      }
      const double a = before * perWay_[d], b = beyond * perWay_[d];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave;
  }

  [[nodiscard]] bool holds(Vec3 place) const {
    const Vec3 along = to_ - from_;
    const double time = glm::dot(place - from_, along) * perLength2_;
    if (!(time > 0 && time < 1)) return false;
    const double near2 = near_m_ * near_m_;
    return squaredLength(from_ + along * time - place) <= near2 && squaredLength(place - from_) > near2 &&
           squaredLength(place - to_) > near2;
  }

 private:
  Vec3 from_, to_;
  Vec3 perWay_;
  double perLength2_;
  double near_m_;
};

/// Is any(item) for one of the items in leaves to which the edge comes near?
template <class Any>
bool anyNear(const BoxTree& tree, const Edge& edge, Work& work, Any any) {
  std::array<std::size_t, 64> stack;
  std::size_t top = 0;
  stack[top++] = BoxTree::kRoot;
  while (top > 0 && work.spend(2)) {
    const std::size_t node = stack[--top];
    if (!edge.comesNear(tree.box(node))) continue;
    if (!tree.isLeaf(node)) {
      stack[top++] = 2 * node;
      stack[top++] = 2 * node + 1;
      continue;
    }
    work.spend(3 * BoxTree::kMaxInLeaf);
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
    const Edge edge{Vec3(vertices[a]), Vec3(vertices[b]), near_m};
    const auto isOn = [&, a = a, b = b](std::uint32_t end) {
      const std::uint32_t v = ends[end];
      return v != a && v != b && edge.holds(Vec3(vertices[v]));
    };
    if (anyNear(tree, edge, work, isOn)) ++count;
    if (work.isOver()) return std::nullopt;
  }
  return count;
}

}  // namespace haptics

#include "common/mesh/t_junctions.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "common/mesh/morton.h"

namespace haptics {
namespace {

/// Of the extent: 16 times the rounding of a float coordinate. Larger takes near misses for junctions.
constexpr double kOn = 0x1p-20;

/// Boxes that are looked into, for all edges and for each. An edge of a soup that crosses it all needs some hundred.
constexpr std::int64_t kMostBoxes = std::int64_t{1} << 24;
constexpr std::int64_t kMostBoxesEach = 512;

/// Points in boxes under a complete binary tree, along a Morton curve.
class PointTree {
 public:
  PointTree(const std::vector<Vec3f>& vertices, std::vector<std::uint32_t> points)
      : vertices_(vertices), leaves_(std::bit_ceil((points.size() + kLeaf - 1) / kLeaf)), boxes_(2 * leaves_) {
    for (const std::uint32_t i : mortonOrder(static_cast<std::uint32_t>(points.size()),
                                             [&](std::uint32_t j) { return Vec3(vertices[points[j]]); })) {
      points_.push_back(points[i]);
    }
    for (std::size_t node = boxes_.size() - 1; node > 0; --node) fit(node);
  }

  /// Calls any(vertex) for those whose boxes come as near to the line from a to b as that, until it returns true, and
  /// then returns true. Adds the boxes looked into to `spent`.
  template <class Any>
  [[nodiscard]] bool anyNear(Vec3 a, Vec3 b, double near_m, std::int64_t& spent, Any any) const {
    std::array<std::size_t, 64> stack;
    std::size_t top = 0;
    stack[top++] = 1;
    while (top > 0) {
      const std::size_t node = stack[--top];
      ++spent;
      if (!boxes_[node].isMet(a, b, near_m)) continue;
      if (node < leaves_) {
        stack[top++] = 2 * node;
        stack[top++] = 2 * node + 1;
        continue;
      }
      const auto leaf = this->leaf(node);
      if (std::any_of(leaf.begin(), leaf.end(), any)) return true;
    }
    return false;
  }

 private:
  static constexpr std::size_t kLeaf = 8;

  struct Box {
    Vec3f low{std::numeric_limits<float>::infinity()};
    Vec3f high{-std::numeric_limits<float>::infinity()};

    [[nodiscard]] bool isMet(Vec3 a, Vec3 b, double near_m) const {
      double enter = 0;
      double leave = 1;
      for (int d = 0; d < 3; ++d) {
        const double before = low[d] - near_m - a[d], beyond = high[d] + near_m - a[d], way = b[d] - a[d];
        if (way == 0) {
          if (before > 0 || beyond < 0) return false;
          continue;
        }
        enter = std::max(enter, std::min(before / way, beyond / way));
        leave = std::min(leave, std::max(before / way, beyond / way));
      }
      return enter <= leave;
    }
  };

  [[nodiscard]] std::span<const std::uint32_t> leaf(std::size_t node) const {
    const std::size_t begin = std::min((node - leaves_) * kLeaf, points_.size());
    return std::span(points_).subspan(begin, std::min(kLeaf, points_.size() - begin));
  }

  void fit(std::size_t node) {
    Box& box = boxes_[node];
    if (node < leaves_) {
      box.low = glm::min(boxes_[2 * node].low, boxes_[2 * node + 1].low);
      box.high = glm::max(boxes_[2 * node].high, boxes_[2 * node + 1].high);
      return;
    }
    for (const std::uint32_t v : leaf(node)) {
      box.low = glm::min(box.low, vertices_[v]);
      box.high = glm::max(box.high, vertices_[v]);
    }
  }

  const std::vector<Vec3f>& vertices_;
  std::vector<std::uint32_t> points_;
  std::size_t leaves_;      // a power of two
  std::vector<Box> boxes_;  // the children of i are 2 i and 2 i + 1
};

bool liesOn(Vec3 place, Vec3 a, Vec3 b, double tolerance_m) {
  const Vec3 along = b - a;
  const double time = glm::dot(place - a, along) / squaredLength(along);
  if (!(time > 0 && time < 1)) return false;
  const double near2 = tolerance_m * tolerance_m;
  return squaredLength(a + along * time - place) <= near2 && squaredLength(place - a) > near2 &&
         squaredLength(place - b) > near2;
}

}  // namespace

std::optional<std::uint64_t> countTJunctions(const std::vector<Vec3f>& vertices,
                                             const std::vector<EdgeIndices>& boundary) {
  if (boundary.empty()) return 0;
  std::vector<std::uint32_t> ends;
  Vec3 low(vertices[boundary.front()[0]]), high(low);
  for (const EdgeIndices& edge : boundary) {
    for (const std::uint32_t v : edge) {
      ends.push_back(v);
      low = glm::min(low, Vec3(vertices[v]));
      high = glm::max(high, Vec3(vertices[v]));
    }
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  const double tolerance_m = kOn * std::max(glm::length(low), glm::length(high));
  const PointTree tree(vertices, std::move(ends));

  const std::int64_t most = kMostBoxes + kMostBoxesEach * static_cast<std::int64_t>(boundary.size());
  std::int64_t spent = 0;
  std::uint64_t count = 0;
  for (const EdgeIndices& edge : boundary) {
    const Vec3 a(vertices[edge[0]]), b(vertices[edge[1]]);
    const auto isOn = [&](std::uint32_t v) {
      return v != edge[0] && v != edge[1] && liesOn(Vec3(vertices[v]), a, b, tolerance_m);
    };
    if (tree.anyNear(a, b, tolerance_m, spent, isOn)) ++count;
    if (spent > most) return std::nullopt;
  }
  return count;
}

}  // namespace haptics

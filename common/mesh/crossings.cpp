#include "common/mesh/crossings.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "common/mesh/morton.h"

namespace haptics {
namespace {

constexpr std::size_t kLeaf = 8;
/// Pairs of triangles whose boxes are compared, for the mesh and for each of its triangles. A sane mesh needs about 100
/// each.
constexpr std::int64_t kMostTests = std::int64_t{1} << 26;
constexpr std::int64_t kMostTestsEach = 2048;
/// What a test of two triangles costs in comparisons of boxes.
constexpr std::int64_t kTestsPerCrossing = 16;

Vec3 centreOf(const TriMesh& mesh, std::uint32_t triangle) {
  Vec3 centre(0);
  for (const std::uint32_t v : mesh.triangles[triangle]) centre += Vec3(mesh.vertices[v]) / 3.0;
  return centre;
}

}  // namespace

/// Goes through pairs of nodes that meet, both always of one level.
class CrossingSearch::PairWalk {
 public:
  explicit PairWalk(const CrossingSearch& search)
      : search_(search),
        left_(kMostTests + kMostTestsEach * static_cast<std::int64_t>(search.mesh_.triangles.size())) {}

  void within(std::size_t node) {
    if (node >= search_.leaves_) return leaves(node, node);
    within(2 * node);
    within(2 * node + 1);
    between(2 * node, 2 * node + 1);
  }
  [[nodiscard]] bool done() const { return left_ > 0; }
  [[nodiscard]] std::vector<Pair>&& pairs() { return std::move(pairs_); }

 private:
  void between(std::size_t a, std::size_t b) {
    if (left_ <= 0 || !search_.nodes_[a].meets(search_.nodes_[b])) return;
    if (a >= search_.leaves_) return leaves(a, b);
    for (const std::size_t i : {2 * a, 2 * a + 1}) {
      for (const std::size_t j : {2 * b, 2 * b + 1}) between(i, j);
    }
  }

  void leaves(std::size_t a, std::size_t b) {
    const auto ofA = search_.leaf(a);
    const auto ofB = search_.leaf(b);
    std::array<Box, kLeaf> boxes;
    std::transform(ofB.begin(), ofB.end(), boxes.begin(), [&](std::uint32_t t) { return search_.boxOf(t); });
    left_ -= static_cast<std::int64_t>(ofA.size() * ofB.size());
    for (std::size_t i = 0; i < ofA.size(); ++i) {
      const Box box = search_.boxOf(ofA[i]);
      if (!box.meets(search_.nodes_[b])) continue;
      for (std::size_t j = a == b ? i + 1 : 0; j < ofB.size(); ++j) {
        if (!box.meets(boxes[j])) continue;
        left_ -= kTestsPerCrossing;
        if (search_.cross(ofA[i], ofB[j])) pairs_.push_back({ofA[i], ofB[j]});
      }
    }
  }

  const CrossingSearch& search_;
  std::int64_t left_;
  std::vector<Pair> pairs_;
};

CrossingSearch::CrossingSearch(const TriMesh& mesh)
    : mesh_(mesh),
      order_(mortonOrder(static_cast<std::uint32_t>(mesh.triangles.size()),
                         [&](std::uint32_t t) { return centreOf(mesh, t); })),
      place_(order_.size()),
      leaves_(std::bit_ceil((order_.size() + kLeaf - 1) / kLeaf)),
      nodes_(2 * leaves_) {
  for (std::uint32_t i = 0; i < order_.size(); ++i) place_[order_[i]] = i;
  for (std::size_t node = nodes_.size() - 1; node > 0; --node) fit(node);
}

void CrossingSearch::refit(std::span<const std::uint32_t> triangles) {
  std::vector<std::size_t> nodes;
  for (const std::uint32_t t : triangles) nodes.push_back(leaves_ + place_[t] / kLeaf);
  while (!nodes.empty()) {  // all of one level
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    for (std::size_t& node : nodes) {
      fit(node);
      node /= 2;
    }
    if (nodes.front() == 0) break;
  }
}

/// The box of a node about those of its children or triangles.
void CrossingSearch::fit(std::size_t node) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Box box{Vec3f(kInfinity), Vec3f(-kInfinity)};
  const auto join = [&box](const Box& other) {
    box.low = glm::min(box.low, other.low);
    box.high = glm::max(box.high, other.high);
  };
  if (node >= leaves_) {
    for (const std::uint32_t t : leaf(node)) join(boxOf(t));
  } else {
    join(nodes_[2 * node]);
    join(nodes_[2 * node + 1]);
  }
  nodes_[node] = box;
}

std::optional<std::vector<CrossingSearch::Pair>> CrossingSearch::all() const {
  PairWalk walk(*this);
  walk.within(1);
  return walk.done() ? std::optional(walk.pairs()) : std::nullopt;
}

bool CrossingSearch::any(std::span<const std::uint32_t> triangles) const {
  std::vector<std::size_t> stack;
  for (const std::uint32_t t : triangles) {
    const Box box = boxOf(t);
    stack.assign(1, 1);
    while (!stack.empty()) {
      const std::size_t node = stack.back();
      stack.pop_back();
      if (!nodes_[node].meets(box)) continue;
      if (node < leaves_) {
        stack.insert(stack.end(), {2 * node, 2 * node + 1});
        continue;
      }
      const auto others = leaf(node);
      if (std::any_of(others.begin(), others.end(),
                      [&](std::uint32_t other) { return other != t && cross(t, other); })) {
        return true;
      }
    }
  }
  return false;
}

std::span<const std::uint32_t> CrossingSearch::leaf(std::size_t node) const {
  const std::size_t begin = std::min((node - leaves_) * kLeaf, order_.size());
  return std::span(order_).subspan(begin, std::min(kLeaf, order_.size() - begin));
}

CrossingSearch::Box CrossingSearch::boxOf(std::uint32_t triangle) const {
  const auto [a, b, c] = mesh_.triangles[triangle];
  const Vec3f p = mesh_.vertices[a], q = mesh_.vertices[b], r = mesh_.vertices[c];
  return {glm::min(glm::min(p, q), r), glm::max(glm::max(p, q), r)};
}

bool CrossingSearch::cross(std::uint32_t a, std::uint32_t b) const { return pierces(a, b) || pierces(b, a); }

/// Does a side of triangle a pierce triangle b?
bool CrossingSearch::pierces(std::uint32_t a, std::uint32_t b) const {
  const TriangleIndices& sides = mesh_.triangles[a];
  const TriangleIndices& through = mesh_.triangles[b];
  std::array<Vec3, 3> corner;
  std::array<double, 3> height;
  std::array<bool, 3> shared;
  for (std::size_t k = 0; k < 3; ++k) corner[k] = Vec3(mesh_.vertices[through[k]]);
  const Vec3 normal = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
  for (std::size_t k = 0; k < 3; ++k) {
    height[k] = glm::dot(normal, Vec3(mesh_.vertices[sides[k]]) - corner[0]);
    shared[k] = std::find(through.begin(), through.end(), sides[k]) != through.end();
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    if (shared[k] || shared[next] || (height[k] < 0) == (height[next] < 0)) continue;
    const Vec3 from(mesh_.vertices[sides[k]]);
    const Vec3 way = Vec3(mesh_.vertices[sides[next]]) - from;
    int left = 0, right = 0;  // of the triangle's own sides, seen along the way
    for (std::size_t e = 0; e < 3; ++e) {
      const double volume = glm::dot(way, glm::cross(corner[e] - from, corner[(e + 1) % 3] - from));
      left += volume >= 0 ? 1 : 0;
      right += volume <= 0 ? 1 : 0;
    }
    if (left == 3 || right == 3) return true;
  }
  return false;
}

}  // namespace haptics

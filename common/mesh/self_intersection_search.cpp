#include "common/mesh/self_intersection_search.h"

#include <algorithm>
#include <utility>

namespace haptics {
namespace {

/// Units of work that a test of two triangles is.
constexpr std::size_t kCrossing = 16;

bool areOneSide(const std::array<double, 3>& heights) {
  return (heights[0] > 0 && heights[1] > 0 && heights[2] > 0) || (heights[0] < 0 && heights[1] < 0 && heights[2] < 0);
}

}  // namespace

/// Goes through pairs of nodes that meet, both always of one level.
class SelfIntersectionSearch::PairWalk {
 public:
  PairWalk(const SelfIntersectionSearch& search, Work& work) : search_(search), tree_(search.tree_), work_(work) {}

  void within(std::size_t node) {
    if (work_.isOver()) return;
    if (tree_.isLeaf(node)) return leaves(node, node);
    within(2 * node);
    within(2 * node + 1);
    between(2 * node, 2 * node + 1);
  }
  [[nodiscard]] std::vector<Pair>&& pairs() { return std::move(pairs_); }

 private:
  void between(std::size_t a, std::size_t b) {
    if (!work_.spend(1) || !tree_.box(a).meets(tree_.box(b))) return;
    if (tree_.isLeaf(a)) return leaves(a, b);
    for (const std::size_t i : {2 * a, 2 * a + 1}) {
      for (const std::size_t j : {2 * b, 2 * b + 1}) between(i, j);
    }
  }

  void leaves(std::size_t a, std::size_t b) {
    const auto ofA = tree_.leaf(a);
    const auto ofB = tree_.leaf(b);
    std::array<Box, BoxTree::kMaxInLeaf> boxes;
    std::array<Face, BoxTree::kMaxInLeaf> faces;
    std::ranges::transform(ofB, boxes.begin(), [&](std::uint32_t t) { return search_.boxOf(t); });
    std::ranges::transform(ofB, faces.begin(), [&](std::uint32_t t) { return search_.faceOf(t); });
    work_.spend(ofA.size() * ofB.size());
    for (std::size_t i = 0; i < ofA.size(); ++i) {
      const Box box = search_.boxOf(ofA[i]);
      if (!box.meets(tree_.box(b))) continue;
      const Face face = search_.faceOf(ofA[i]);
      for (std::size_t j = a == b ? i + 1 : 0; j < ofB.size(); ++j) {
        if (!box.meets(boxes[j])) continue;
        work_.spend(kCrossing);
        if (intersect(face, faces[j])) pairs_.push_back({ofA[i], ofB[j]});
      }
    }
  }

  const SelfIntersectionSearch& search_;
  const BoxTree& tree_;
  Work& work_;
  std::vector<Pair> pairs_;
};

SelfIntersectionSearch::SelfIntersectionSearch(const TriMesh& mesh)
    : mesh_(mesh),
      tree_(static_cast<std::uint32_t>(mesh.triangles.size()), [this](std::uint32_t t) { return boxOf(t); }) {}

std::optional<std::vector<SelfIntersectionSearch::Pair>> SelfIntersectionSearch::all(Work& work) const {
  PairWalk walk(*this, work);
  walk.within(BoxTree::kRoot);
  return work.isOver() ? std::nullopt : std::optional(walk.pairs());
}

bool SelfIntersectionSearch::any(std::span<const std::uint32_t> triangles, Work& work) const {
  std::vector<std::size_t> stack;
  for (const std::uint32_t t : triangles) {
    const Box box = boxOf(t);
    const Face face = faceOf(t);
    stack.assign(1, BoxTree::kRoot);
    while (!stack.empty()) {
      const std::size_t node = stack.back();
      stack.pop_back();
      if (!work.spend(2)) return true;
      if (!tree_.box(node).meets(box)) continue;
      if (!tree_.isLeaf(node)) {
        stack.insert(stack.end(), {2 * node, 2 * node + 1});
        continue;
      }
      for (const std::uint32_t other : tree_.leaf(node)) {
        work.spend(kCrossing);
        if (other != t && boxOf(other).meets(box) && intersect(face, faceOf(other))) return true;
      }
    }
  }
  return false;
}

Box SelfIntersectionSearch::boxOf(std::uint32_t triangle) const {
  const auto [a, b, c] = mesh_.triangles[triangle];
  const Vec3f p = mesh_.vertices[a], q = mesh_.vertices[b], r = mesh_.vertices[c];
  return {glm::min(glm::min(p, q), r), glm::max(glm::max(p, q), r)};
}

SelfIntersectionSearch::Face SelfIntersectionSearch::faceOf(std::uint32_t triangle) const {
  Face face{.corners = mesh_.triangles[triangle], .at = {}, .normal = {}};
  for (std::size_t k = 0; k < 3; ++k) face.at[k] = Vec3(mesh_.vertices[face.corners[k]]);
  face.normal = glm::cross(face.at[1] - face.at[0], face.at[2] - face.at[0]);
  return face;
}

bool SelfIntersectionSearch::intersect(const Face& a, const Face& b) {
  std::array<double, 3> ofA, ofB;
  for (std::size_t k = 0; k < 3; ++k) ofA[k] = glm::dot(b.normal, a.at[k] - b.at[0]);
  if (areOneSide(ofA)) return false;
  for (std::size_t k = 0; k < 3; ++k) ofB[k] = glm::dot(a.normal, b.at[k] - a.at[0]);
  return !areOneSide(ofB) && (pierces(a, ofA, b) || pierces(b, ofB, a));
}

/// Does a side of triangle a, whose corners are so high over the plane of b, pierce b?
bool SelfIntersectionSearch::pierces(const Face& a, const std::array<double, 3>& heights, const Face& b) {
  std::array<bool, 3> shared;
  for (std::size_t k = 0; k < 3; ++k) shared[k] = std::ranges::find(b.corners, a.corners[k]) != b.corners.end();
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    if (shared[k] || shared[next] || (heights[k] < 0) == (heights[next] < 0)) continue;
    const Vec3 from = a.at[k];
    const Vec3 way = a.at[next] - from;
    int left = 0, right = 0;  // of the triangle's own sides, seen along the way
    for (std::size_t e = 0; e < 3; ++e) {
      const double volume = glm::dot(way, glm::cross(b.at[e] - from, b.at[(e + 1) % 3] - from));
      left += volume >= 0 ? 1 : 0;
      right += volume <= 0 ? 1 : 0;
    }
    if (left == 3 || right == 3) return true;
  }
  return false;
}

}  // namespace haptics

#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "common/maths/sse.h"
#include "common/maths/vec.h"
#include "haptic_server/engine/geometry/allowance.h"
#include "haptic_server/engine/geometry/large_pages.h"
#include "haptic_server/engine/geometry/long_triangles.h"
#include "haptic_server/engine/geometry/triangle_record.h"

namespace haptics {

/// Axis-aligned boxes eight to a node (paper 3.2: "hierarchical bounding boxes", Gottschalk et al. 1996; here boxes of
/// one orientation, which are four times cheaper to test and as tight on small triangles). Leaves are runs of triangles
/// in the hierarchy's own order; where long triangles overlap, cells of a grid that list what passes through them
/// (long_triangles.h): a query may meet such a triangle more than once. Immutable after build(); the queries neither
/// allocate nor lock.
class BoundingHierarchy {
 public:
  static constexpr int kWidth = 8;
  /// Triangles in a leaf, at most. More make a smaller tree and a slower query.
  static constexpr std::uint32_t kLeafTriangles = 8;
  /// Triangles that are divided among the free places of a node, though they would fit into one leaf. Fewer make
  /// queries faster as long as there are places, and the tree no larger.
  static constexpr std::uint32_t kDivided = 3;
  /// Levels that the surface area heuristic may use; below, ranges are halved, so that the depth stays below kMaxDepth
  /// for any input.
  static constexpr int kHeuristicDepth = 12;
  static constexpr int kMaxDepth = 22;
  static constexpr int kStackSize = (kWidth - 1) * kMaxDepth + kWidth;
  /// Boxes are tested in float and are widened by this fraction of the mesh's extent, 16 times the rounding of a float
  /// coordinate. Smaller loses crossings; larger costs time.
  static constexpr double kBoxPad = 0x1p-20;
  /// Segments shorter than this fraction of the root's box are looked for by their own box, which costs half as much
  /// per node. Larger meets more leaves in vain; smaller makes slower ticks.
  static constexpr double kShort = 0x1p-8;

  /// Times of meeting a box are rounded to float: looks this fraction beyond the end, more than the boxes' padding hides.
  static constexpr float kTimeSlack = 0x1p-20F;

  /// What lies in a box: a node, or a leaf's triangles. 2^28 of either can be told apart.
  class Child {
   public:
    Child() = default;
    static Child node(std::uint32_t index) { return Child(index); }
    static Child leaf(std::uint32_t first, std::uint32_t count) { return Child(first | count << kIndexBits); }
    static Child list(std::uint32_t index) { return Child(index | kList << kIndexBits); }

    [[nodiscard]] bool isLeaf() const noexcept { return bits_ >> kIndexBits != 0; }
    [[nodiscard]] bool isList() const noexcept { return bits_ >> kIndexBits == kList; }              ///< And a leaf.
    [[nodiscard]] std::uint32_t index() const noexcept { return bits_; }                             ///< Of a node.
    [[nodiscard]] std::uint32_t begin() const noexcept { return bits_ & ((1U << kIndexBits) - 1); }  ///< Of a leaf.
    [[nodiscard]] std::uint32_t end() const noexcept { return begin() + (bits_ >> kIndexBits); }

   private:
    static constexpr int kIndexBits = 28;
    static constexpr std::uint32_t kList = 15;
    static_assert(kLeafTriangles < kList);
    explicit Child(std::uint32_t bits) : bits_(bits) {}
    std::uint32_t bits_ = 0;
  };
  struct alignas(32) Node {
    float bounds[2][3][kWidth];  // low, high; inverted when the place is empty
    Child child[kWidth];
  };
  static_assert(sizeof(Node) == 224);
  struct Slabs;
  struct Window;

  /// Builds over the triangles with binned surface area heuristic (Wald 2007). Returns the order of the leaves: place
  /// in the hierarchy -> index in `triangles`. `extent_m` is the largest coordinate. The result does not depend on
  /// `threads`.
  LargePageVector<std::uint32_t> build(std::span<const Vec3f> vertices,
                                       std::span<const std::array<std::uint32_t, 3>> triangles, double extent_m,
                                       int threads);

  /// Makes the boxes anew around the same triangles, which have moved; `triangles` are in the hierarchy's order.
  void refit(std::span<const TriangleRecord> triangles, double extent_m);
  /// The same without allocating. A cell keeps its list, and its box is that of all triangles in it: queries find as much, and
  /// look at more.
  void refitInPlace(std::span<const TriangleRecord> triangles, double extent_m) noexcept;

  /// Calls visit(begin, end) for the leaves that the segment may meet; visit returns the time up to which the segment
  /// is still of interest (fraction of from -> to). The segment is first clipped to the root's box in double, so that a
  /// start far away does not cost the float test its precision. A segment that is not finite meets nothing. Every
  /// visit ends once the allowance is spent; what the leaves cost is for the visitor to spend.
  template <class Visit>
  void visitAlong(Vec3 from, Vec3 to, Allowance& allowance, Visit visit) const noexcept(noexcept(visit(0U, 0U)));

  /// Calls visit(begin, end) for the leaves that overlap the box. Tests eight boxes at once where the processor has AVX,
  /// else four; visits the same leaves in the same order.
  template <class Visit>
  void visitBox(Vec3f low, Vec3f high, Allowance& allowance, Visit visit) const noexcept(noexcept(visit(0U, 0U))) {
#if defined(__x86_64__)
    if (wide_) return visitBoxByEight(low, high, allowance, visit);
#endif
    return visitBoxByFour(low, high, allowance, visit);
  }
  /// Whether visitBox() may use AVX; false is for tests.
  void setWide(bool wide) noexcept { wide_ = wide && hasAvx(); }

  /// Calls visit(begin, end) for the leaves nearer to h than the bound, near ones first; visit returns the squared
  /// distance (m^2) beyond which nothing is of interest, negative to stop. `bound` is the one to begin with. leaveOut is
  /// called with a squared distance that no triangle of a box left out is nearer than.
  template <class Visit, class LeaveOut = decltype([](double) noexcept {})>
  void visitNear(Vec3 h, Allowance& allowance, Visit visit, double bound = std::numeric_limits<double>::infinity(),
                 LeaveOut leaveOut = {}) const noexcept;

  [[nodiscard]] std::span<const Node> nodes() const noexcept { return nodes_; }
  [[nodiscard]] bool hasCells() const noexcept { return !listEnds_.empty(); }
  [[nodiscard]] std::size_t cellCount() const noexcept { return listEnds_.size(); }
  /// Triangles that pass through a cell.
  [[nodiscard]] std::span<const std::uint32_t> cell(std::size_t i) const noexcept {
    const std::uint32_t begin = i == 0 ? 0 : listEnds_[i - 1];
    return std::span(listed_).subspan(begin, listEnds_[i] - begin);
  }
  /// From this one on, in the hierarchy's order, triangles are in cells; their number where none are.
  [[nodiscard]] std::uint32_t firstInCells() const noexcept { return firstInCells_; }
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return nodes_.capacity() * sizeof(Node) + (listed_.capacity() + listEnds_.capacity()) * sizeof(std::uint32_t);
  }

 private:
  void measure(double extent_m);
  void dropCells();
  void appendCells(std::uint32_t first, std::uint32_t count, const std::function<Corners(std::uint32_t)>& corners);
  /// Calls visit for a leaf; returns what the last call did.
  template <class Visit>
  auto enterLeaf(Child leaf, const Allowance& allowance, Visit& visit) const noexcept(noexcept(visit(0U, 0U))) {
    if (!leaf.isList()) [[likely]]
      return visit(leaf.begin(), leaf.end());
    return enterList(leaf.begin(), allowance, visit);
  }
  /// Lists may be long: each of its triangles looks at the allowance.
  template <class Visit>
  [[gnu::noinline]] auto enterList(std::uint32_t list, const Allowance& allowance, Visit& visit) const
      noexcept(noexcept(visit(0U, 0U))) {
    std::uint32_t at = list == 0 ? 0 : listEnds_[list - 1];
    const std::uint32_t last = listEnds_[list] - 1;  // none is empty
    for (; at < last && !allowance.isSpent(); ++at) visit(listed_[at], listed_[at] + 1);
    return visit(listed_[at], listed_[at] + 1);
  }

#if defined(__x86_64__)
  struct WideWindow;
#endif
  using Stack = std::array<std::uint32_t, kStackSize>;
  struct Ranked {
    float squaredDistance;
    Child child;
  };
  template <class Visit>
  void visitBoxByFour(Vec3f low, Vec3f high, Allowance& allowance, Visit& visit) const
      noexcept(noexcept(visit(0U, 0U)));
#if defined(__x86_64__)
  template <class Visit>
  [[gnu::target("avx")]] void visitBoxByEight(Vec3f low, Vec3f high, Allowance& allowance, Visit& visit) const
      noexcept(noexcept(visit(0U, 0U)));
  [[nodiscard]] static bool hasAvx() noexcept { return __builtin_cpu_supports("avx") != 0; }
#else
  [[nodiscard]] static bool hasAvx() noexcept { return false; }
#endif
  /// Calls visit for the leaves among the node's `hits`, and puts the nodes among them on the stack.
  template <class Visit>
  void enter(const Node& node, int hits, Stack& stack, std::size_t& top, const Allowance& allowance,
             Visit& visit) const {
    for (auto rest = static_cast<unsigned>(hits); rest != 0; rest &= rest - 1) {
      const Child child = node.child[std::countr_zero(rest)];
      if (child.isLeaf()) {
        enterLeaf(child, allowance, visit);
      } else {
        stack[top++] = child.index();
      }
    }
  }
  [[nodiscard]] bool clip(Vec3 from, Vec3 to, double& enter, double& leave) const noexcept;
  [[nodiscard]] static __m128 squaredDistances(const Node& node, Vec3f h, int half) noexcept;

  LargePageVector<Node> nodes_;
  std::vector<std::uint32_t> listed_;
  std::vector<std::uint32_t> listEnds_;  // of each cell
  std::uint32_t firstInCells_ = 0;       // triangle in the hierarchy's order
  std::uint32_t firstCellNode_ = 0;
  Vec3 low_{0};  // of the root, padded
  Vec3 high_{0};
  double short_ = 0;  // m
  bool wide_ = hasAvx();
};

/// A segment prepared for the test of four boxes at a time.
struct BoundingHierarchy::Slabs {
  __m128 origin[3];
  __m128 inverse[3];
  int nearSide[3];  // 0 when the low face is met first

  Slabs(Vec3 from, Vec3 to) noexcept {
    const Vec3f o(from);
    const Vec3f d = Vec3f(to) - o;
    for (int k = 0; k < 3; ++k) {
      float inv = 1 / d[k];
      if (!std::isfinite(inv)) inv = std::copysign(std::numeric_limits<float>::max(), d[k]);
      origin[k] = _mm_set1_ps(o[k]);
      inverse[k] = _mm_set1_ps(inv);
      nearSide[k] = inv < 0 ? 1 : 0;
    }
  }
  /// Bit i: box 4 * half + i is met before `limit`.
  [[nodiscard]] int meet(const Node& node, int half, __m128 limit) const noexcept {
    __m128 entry = _mm_setzero_ps();
    __m128 exit = limit;
    for (int d = 0; d < 3; ++d) {
      const __m128 near = _mm_load_ps(node.bounds[nearSide[d]][d] + 4 * half);
      const __m128 far = _mm_load_ps(node.bounds[1 - nearSide[d]][d] + 4 * half);
      entry = _mm_max_ps(_mm_mul_ps(_mm_sub_ps(near, origin[d]), inverse[d]), entry);
      exit = _mm_min_ps(_mm_mul_ps(_mm_sub_ps(far, origin[d]), inverse[d]), exit);
    }
    return _mm_movemask_ps(_mm_cmple_ps(entry, exit));
  }
};

/// A box prepared for the test against four at a time.
struct BoundingHierarchy::Window {
  __m128 low[3];
  __m128 high[3];

  Window(Vec3f l, Vec3f h) noexcept {
    for (int d = 0; d < 3; ++d) {
      low[d] = _mm_set1_ps(l[d]);
      high[d] = _mm_set1_ps(h[d]);
    }
  }
  /// Bit i: overlaps box 4 * half + i.
  [[nodiscard]] int meet(const Node& node, int half) const noexcept {
    __m128 both = _mm_cmple_ps(_mm_load_ps(node.bounds[0][0] + 4 * half), high[0]);
    both = _mm_and_ps(both, _mm_cmple_ps(low[0], _mm_load_ps(node.bounds[1][0] + 4 * half)));
    for (int d = 1; d < 3; ++d) {
      both = _mm_and_ps(both, _mm_cmple_ps(_mm_load_ps(node.bounds[0][d] + 4 * half), high[d]));
      both = _mm_and_ps(both, _mm_cmple_ps(low[d], _mm_load_ps(node.bounds[1][d] + 4 * half)));
    }
    return _mm_movemask_ps(both);
  }
};

template <class Visit>
void BoundingHierarchy::visitAlong(Vec3 from, Vec3 to, Allowance& allowance, Visit visit) const
    noexcept(noexcept(visit(0U, 0U))) {
  // A box that is rounded to float far outside stays far outside.
  const Vec3 size = glm::abs(to - from);
  if (size.x < short_ && size.y < short_ && size.z < short_) {
    return visitBox(Vec3f(glm::min(from, to)), Vec3f(glm::max(from, to)), allowance, visit);
  }
  double enter = 0;
  double leave = 1;
  if (!clip(from, to, enter, leave)) return;
  const double scale = leave > enter ? 1 / (leave - enter) : 0;
  const Vec3 d = to - from;
  const Slabs slabs(enter > 0 ? from + d * enter : from, leave < 1 ? from + d * leave : to);
  __m128 limit = _mm_set1_ps(1 + kTimeSlack);
  Stack stack;
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0 && !allowance.isSpent()) {
    allowance.spend(Allowance::kNode);
    const Node& node = nodes_[stack[--top]];
    const int hits = slabs.meet(node, 0, limit) | slabs.meet(node, 1, limit) << 4;
    for (auto rest = static_cast<unsigned>(hits); rest != 0; rest &= rest - 1) {
      const int i = std::countr_zero(rest);
      const Child child = node.child[i];
      if (!child.isLeaf()) {
        stack[top++] = child.index();
        continue;
      }
      const double time = enterLeaf(child, allowance, visit);
      if (time < leave) limit = _mm_set1_ps(static_cast<float>((time - enter) * scale) + kTimeSlack);
    }
  }
}

template <class Visit>
void BoundingHierarchy::visitBoxByFour(Vec3f low, Vec3f high, Allowance& allowance, Visit& visit) const
    noexcept(noexcept(visit(0U, 0U))) {
  const Window window(low, high);
  Stack stack;
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0 && !allowance.isSpent()) {
    allowance.spend(Allowance::kNode);
    const Node& node = nodes_[stack[--top]];
    enter(node, window.meet(node, 0) | window.meet(node, 1) << 4, stack, top, allowance, visit);
  }
}

#if defined(__x86_64__)
/// The same for eight at a time. By GCC's vectors: the header of AVX's intrinsics has 30,000 lines.
struct BoundingHierarchy::WideWindow {
  using Float8 = float __attribute__((vector_size(32), may_alias));
  Float8 low[3];
  Float8 high[3];

  [[gnu::target("avx")]] WideWindow(Vec3f l, Vec3f h) noexcept {
    for (int d = 0; d < 3; ++d) {
      low[d] = l[d] - Float8{};
      high[d] = h[d] - Float8{};
    }
  }
  /// Bit i: overlaps box i.
  [[nodiscard, gnu::target("avx")]] int meet(const Node& node) const noexcept {
    const auto face = [&](int side, int d) -> const Float8& {
      return *reinterpret_cast<const Float8*>(node.bounds[side][d]);
    };
    auto both = (face(0, 0) <= high[0]) & (low[0] <= face(1, 0));
    for (int d = 1; d < 3; ++d) both &= (face(0, d) <= high[d]) & (low[d] <= face(1, d));
    return __builtin_ia32_movmskps256(reinterpret_cast<Float8>(both));
  }
};

template <class Visit>
void BoundingHierarchy::visitBoxByEight(Vec3f low, Vec3f high, Allowance& allowance, Visit& visit) const
    noexcept(noexcept(visit(0U, 0U))) {
  const WideWindow window(low, high);
  Stack stack;
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0 && !allowance.isSpent()) {
    allowance.spend(Allowance::kNode);
    const Node& node = nodes_[stack[--top]];
    enter(node, window.meet(node), stack, top, allowance, visit);
  }
}
#endif

template <class Visit, class LeaveOut>
void BoundingHierarchy::visitNear(Vec3 h, Allowance& allowance, Visit visit, double bound,
                                  LeaveOut leaveOut) const noexcept {
  constexpr float kSlack = 1 - 0x1p-20F;  // distances are rounded to float: never leaves out a box for that
  const Vec3f at(h);
  std::array<Ranked, kStackSize> stack;
  std::size_t top = 0;
  stack[top++] = {0, Child::node(0)};
  while (top > 0 && !allowance.isSpent()) {
    const Ranked here = stack[--top];
    if (here.squaredDistance * kSlack >= bound) {
      leaveOut(here.squaredDistance * kSlack);
      continue;
    }
    if (here.child.isLeaf()) {
      bound = enterLeaf(here.child, allowance, visit);
      if (bound < 0) return;
      continue;
    }
    allowance.spend(3 * Allowance::kNode);  // ranked by distance
    const Node& node = nodes_[here.child.index()];
    alignas(16) std::array<float, kWidth> distance;
    _mm_store_ps(distance.data(), squaredDistances(node, at, 0));
    _mm_store_ps(distance.data() + 4, squaredDistances(node, at, 1));
    const std::size_t base = top;
    for (std::size_t i = 0; i < kWidth; ++i) {
      const bool empty = node.bounds[0][0][i] > node.bounds[1][0][i];
      if (empty) continue;
      if (distance[i] * kSlack >= bound) {
        leaveOut(distance[i] * kSlack);
        continue;
      }
      std::size_t place = top++;
      for (; place > base && stack[place - 1].squaredDistance < distance[i]; --place) stack[place] = stack[place - 1];
      stack[place] = {distance[i], node.child[i]};
    }
  }
}

inline bool BoundingHierarchy::clip(Vec3 from, Vec3 to, double& enter, double& leave) const noexcept {
  const Vec3 motion = to - from;
  if (!std::isfinite(motion.x + motion.y + motion.z)) return false;
  for (int k = 0; k < 3; ++k) {
    const double d = motion[k];
    if (d == 0) {
      if (!(from[k] >= low_[k] && from[k] <= high_[k])) return false;
      continue;
    }
    const double a = (low_[k] - from[k]) / d;
    const double b = (high_[k] - from[k]) / d;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave;
}

inline __m128 BoundingHierarchy::squaredDistances(const Node& node, Vec3f h, int half) noexcept {
  __m128 sum = _mm_setzero_ps();
  for (int d = 0; d < 3; ++d) {
    const __m128 at = _mm_set1_ps(h[d]);
    const __m128 below = _mm_sub_ps(_mm_load_ps(node.bounds[0][d] + 4 * half), at);
    const __m128 above = _mm_sub_ps(at, _mm_load_ps(node.bounds[1][d] + 4 * half));
    const __m128 gap = _mm_max_ps(_mm_max_ps(below, above), _mm_setzero_ps());
    sum = _mm_add_ps(sum, _mm_mul_ps(gap, gap));
  }
  return sum;
}

}  // namespace haptics

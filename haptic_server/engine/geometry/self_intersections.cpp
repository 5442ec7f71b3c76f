#include <algorithm>
#include <atomic>
#include <numeric>

#include "common/interruption/grow.h"
#include "common/interruption/threads.h"
#include "haptic_server/engine/geometry/collision_mesh.h"
#include "haptic_server/engine/geometry/float_box.h"
#include "haptic_server/engine/geometry/neighbours.h"

namespace haptics {
namespace {

/// Costs are counted in box tests of four triangles; a test of a line against a triangle costs as much as these.
constexpr std::int64_t kBoxTestsPerTest = 16;

using Marks = std::vector<std::atomic<bool>>;

/// Triangles [begin, end) of the hierarchy's order.
struct Leaf {
  std::uint32_t begin, end;
};

/// Triangles that may be pierced by some line, with their boxes, eight to a block.
class Candidates {
 public:
  static constexpr std::size_t kBlocks = 16;
  static constexpr std::size_t kCapacity = kBlocks * BoundingHierarchy::kWidth;

  [[nodiscard]] bool full() const { return count_ == kCapacity; }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::uint32_t operator[](std::size_t i) const {
    return blocks_[i / BoundingHierarchy::kWidth].triangle[i % BoundingHierarchy::kWidth];
  }
  void clear() { count_ = 0; }

  void add(std::uint32_t t, const TriangleRecord& r, const FloatBox& box) {
    Block& block = blocks_[count_ / BoundingHierarchy::kWidth];
    const std::size_t place = count_++ % BoundingHierarchy::kWidth;
    const std::array bounds{stored(box.low), stored(box.high)};
    for (std::size_t d = 0; d < 3; ++d) {
      block.boxes.bounds[0][d][place] = bounds[0][d];
      block.boxes.bounds[1][d][place] = bounds[1][d];
      block.vertex[d][place] = r.vertex[d];
    }
    block.triangle[place] = t;
  }

  /// Calls visit(triangle) for those whose boxes meet the line and that have neither of its vertices a and b, around
  /// which all meet. Few boxes overlap that of the line, and are asked whether they meet the line itself.
  template <class Visit>
  void visit(Vec3 from, Vec3 to, std::uint32_t a, std::uint32_t b, Visit visit) const {
    const BoundingHierarchy::Window window(Vec3f(glm::min(from, to)), Vec3f(glm::max(from, to)));
    const __m128 end = _mm_set1_ps(1 + BoundingHierarchy::kTimeSlack);
    for (std::size_t i = 0; i < count_; i += 4) {
      const Block& block = blocks_[i / BoundingHierarchy::kWidth];
      const std::size_t first = i % BoundingHierarchy::kWidth;
      const int half = first == 0 ? 0 : 1;
      int met = window.meet(block.boxes, half) & ~sharing(block, first, a, b);
      if (met == 0) continue;
      met &= BoundingHierarchy::Slabs(from, to).meet(block.boxes, half, end);
      for (auto rest = static_cast<unsigned>(met); rest != 0; rest &= rest - 1) {
        const auto place = static_cast<std::size_t>(std::countr_zero(rest));
        if (i + place < count_) visit(block.triangle[first + place]);
      }
    }
  }

 private:
  struct Block {
    BoundingHierarchy::Node boxes;
    std::uint32_t triangle[BoundingHierarchy::kWidth];
    alignas(16) std::uint32_t vertex[3][BoundingHierarchy::kWidth];
  };

  static int sharing(const Block& block, std::size_t first, std::uint32_t a, std::uint32_t b) {
    __m128i shares = _mm_setzero_si128();
    for (const auto& row : block.vertex) {
      const __m128i vertex = _mm_load_si128(reinterpret_cast<const __m128i*>(row + first));
      shares = _mm_or_si128(shares, _mm_cmpeq_epi32(vertex, _mm_set1_epi32(static_cast<int>(a))));
      shares = _mm_or_si128(shares, _mm_cmpeq_epi32(vertex, _mm_set1_epi32(static_cast<int>(b))));
    }
    return _mm_movemask_ps(_mm_castsi128_ps(shares));
  }

  std::size_t count_ = 0;
  std::array<Block, kBlocks> blocks_{};
};

/// Between two parts of a mesh, in paddings of the hierarchy's boxes: a thinner gap is closed, that is, the parts are taken
/// for ones that pass through each other.
constexpr double kGap = 1.75;

/// For each triangle the first triangle of its part, which no line joins with another one; none where there is one part
/// only.
std::vector<std::uint32_t> partsOf(const CollisionMesh& surface) {
  std::vector<std::uint32_t> before;  // one of the same part that is no later
  growTo(before, surface.triangleCount());
  std::iota(before.begin(), before.end(), 0);
  const auto firstOf = [&](std::uint32_t t) {
    while (before[t] != t) t = before[t] = before[before[t]];
    return t;
  };
  std::uint32_t parts = surface.triangleCount();
  for (std::uint32_t t = 0; t < before.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t next = surface.triangle(t).neighbour(k);
      if (next > t) continue;  // or none: met from the other
      const std::uint32_t a = firstOf(t), b = firstOf(next);
      if (a == b) continue;
      before[std::max(a, b)] = std::min(a, b);
      --parts;
    }
  }
  if (parts == 1) return {};
  for (std::uint32_t t = 0; t < before.size(); ++t) before[t] = firstOf(t);
  return before;
}

/// Where the lines of some triangles pierce triangles that they share no vertex with, or all but pierce ones of another part,
/// wherever one of the two has changed. A whole leaf's lines are looked at together: the tree is gone through once for all of them.
class SelfIntersectionSearch {
 public:
  /// @param parts  partsOf().
  SelfIntersectionSearch(const CollisionMesh& surface, std::span<const std::uint8_t> changed,
                         std::span<const std::uint32_t> parts, Marks& marks)
      : surface_(surface), changed_(changed), parts_(parts), marks_(marks) {}

  /// Looks at the lines of those of the leaf's triangles that have changed, and at what lines pierce them. Returns the cost
  /// in box tests; a leaf that costs more than `most` is not looked at to its end.
  std::int64_t run(Leaf leaf, std::int64_t most = std::numeric_limits<std::int64_t>::max()) {
    spent_ = 0;
    FloatBox own;
    own_.clear();
    for (std::uint32_t t = leaf.begin; t < leaf.end; ++t) {
      if (!hasChanged(t)) continue;
      add(t, own_);
      own.grow(FloatBox(surface_.triangle(t)));
    }
    if (own_.count() == 0) return 0;
    const FloatBox met = own.padded(parts_.empty() ? 0 : pad_);
    const FloatBox reached = own.padded(parts_.empty() ? 0 : static_cast<float>(kGap) * pad_);
    Allowance allowance;
    const auto look = [&](std::uint32_t first, std::uint32_t last) {
      if (spent_ > most) allowance = Allowance(-1);
      if (allowance.isSpent()) return;
      spent_ += last - first;
      for (std::uint32_t t = first; t < last; ++t) {
        const FloatBox box = FloatBox(surface_.triangle(t)).padded(pad_);
        if (!box.overlaps(reached)) continue;
        if (near_.full()) followAll();
        near_.add(t, surface_.triangle(t), box);
        const bool looksAtThese = hasChanged(t) && t < surface_.hierarchy().firstInCells();
        if (!looksAtThese) piercing_.push_back(t);
      }
    };
    surface_.hierarchy().visitBox(vec3f(met.low), vec3f(met.high), allowance, look);
    followAll();
    return spent_;
  }

  /// Looks at the triangles in a cell, each against all others there; one that no other shares a vertex with only until it
  /// is known to cross something. Returns the cost in box tests.
  /// @param uses  Triangles at each vertex.
  std::int64_t runCell(std::span<const std::uint32_t> cell, std::span<const std::uint8_t> uses) {
    spent_ = 0;
    for (std::size_t i = 0; i < cell.size(); ++i) {
      const std::uint32_t t = cell[i];
      const bool alone =
          std::ranges::all_of(surface_.triangle(t).vertex, [&](std::uint32_t v) { return uses[v] == 1; });
      own_.clear();
      add(t, own_);
      for (std::size_t j = alone ? 0 : i + 1; j < cell.size() && !(alone && marks_[t]); j += kFew) {
        for (const std::uint32_t other : cell.subspan(j, std::min(kFew, cell.size() - j))) {
          if (other != t) add(other, near_);
        }
        followLines(t, near_);
        for (std::size_t k = 0; k < near_.count(); ++k) followLines(near_[k], own_);
        spent_ += static_cast<std::int64_t>(near_.count());
        near_.clear();
      }
    }
    return spent_;
  }

 private:
  static constexpr std::size_t kFew = 8;  // looked at together
  static_assert(BoundingHierarchy::kLeafTriangles <= Candidates::kCapacity);

  [[nodiscard]] bool hasChanged(std::uint32_t t) const { return changed_[t] != 0; }

  void add(std::uint32_t t, Candidates& to) const {
    const TriangleRecord& r = surface_.triangle(t);
    to.add(t, r, FloatBox(r).padded(pad_));
  }

  void followAll() {
    for (std::size_t i = 0; i < own_.count(); ++i) followLines(own_[i], near_);
    for (const std::uint32_t t : piercing_) followLines(t, own_);
    piercing_.clear();
    near_.clear();
  }

  void followLines(std::uint32_t t, const Candidates& candidates) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t across = surface_.triangle(t).neighbour(k);
      if (across == kNoTriangle || across > t) follow(t, k, candidates);  // else looked at from its other polygon
    }
  }

  void follow(std::uint32_t t, int k, const Candidates& candidates) {
    const TriangleRecord& own = surface_.triangle(t);
    const Vec3 from = own.corner(k);
    const Vec3 to = own.corner(nextCorner(k));
    const Vec3 beyond = parts_.empty() ? Vec3(0) : (to - from) * (kGap * pad_ / glm::distance(from, to));
    spent_ += static_cast<std::int64_t>(candidates.count() / 4);
    candidates.visit(
        from - beyond, to + beyond, own.vertexAt(k), own.vertexAt(nextCorner(k)), [&](std::uint32_t other) {
          spent_ += kBoxTestsPerTest;
          const TriangleRecord& met = surface_.triangle(other);
          Crossing crossing;
          const bool isApart = !parts_.empty() && parts_[t] != parts_[other];
          const bool crosses =
              isApart ? RimmedSegment(from - beyond, to + beyond, kGap / 2 * pad_).enters(met, true, crossing)
                      : Segment(from, to).enters(met, true, crossing);
          if (!crosses) return;
          for (const std::uint32_t crossed : {t, other, own.neighbour(k)}) {
            if (crossed != kNoTriangle) mark(crossed);
          }
          markFan(other, own);
          if (own.neighbour(k) != kNoTriangle) markFan(other, surface_.triangle(own.neighbour(k)));
        });
  }

  void mark(std::uint32_t t) { marks_[t].store(true, std::memory_order_relaxed); }

  /// All triangles around the vertex that two have in common: around it one cannot go from one to the next without
  /// passing through a third.
  void markFan(std::uint32_t t, const TriangleRecord& crossed) {
    for (int k = 0; k < 3; ++k) {
      if (crossed.cornerOf(surface_.triangle(t).vertexAt(k)) < 0) continue;
      visitFan(surface_, t, k, [&](std::uint32_t other, int) {
        mark(other);
        return true;
      });
    }
  }

  const CollisionMesh& surface_;
  std::span<const std::uint8_t> changed_;
  std::span<const std::uint32_t> parts_;
  Marks& marks_;
  const float pad_ = static_cast<float>(surface_.extent_m() * BoundingHierarchy::kBoxPad);
  Candidates own_;                       // of the leaf, those that have changed
  Candidates near_;                      // whose boxes meet theirs
  std::vector<std::uint32_t> piercing_;  // of these, whose lines are looked at from here alone
  std::int64_t spent_ = 0;               // box tests
};

/// Triangles at each vertex; 255 for more.
std::vector<std::uint8_t> usesOfVertices(const CollisionMesh& surface, std::size_t vertices) {
  std::vector<std::uint8_t> uses(vertices, 0);
  for (std::uint32_t t = 0; t < surface.triangleCount(); ++t) {
    for (const std::uint32_t v : surface.triangle(t).vertex) {
      if (uses[v] < 255) ++uses[v];
    }
  }
  return uses;
}

std::vector<Leaf> leavesOf(const BoundingHierarchy& hierarchy) {
  std::vector<Leaf> leaves;
  for (const auto& node : hierarchy.nodes()) {
    for (const auto child : node.child) {
      if (child.isLeaf() && !child.isList()) leaves.push_back({child.begin(), child.end()});
    }
  }
  return leaves;
}

/// Whether a sample of the leaves costs half as much again as its share of `most`. That of one leaf counts up to four shares: where
/// all cost no more than `most`, the mean of the sample, at most 1, strays by 0.11 (standard deviation).
bool costsMore(std::span<const Leaf> leaves, std::int64_t most, SelfIntersectionSearch& search) {
  constexpr std::size_t kSampled = 256;
  if (leaves.size() < 64 * kSampled) return false;
  const std::int64_t share = most / static_cast<std::int64_t>(leaves.size());
  std::int64_t spent = 0;
  for (std::size_t i = 0; i < kSampled; ++i) {
    spent += std::min(search.run(leaves[i * leaves.size() / kSampled], 4 * share), 4 * share);
  }
  return spent > kSampled * 3 / 2 * share;
}

}  // namespace

void CollisionMesh::markSelfIntersecting(std::span<const std::uint8_t> changed, int threads) {
  constexpr std::size_t kPiece = 4096;  // leaves that a thread takes at a time
  Marks marks(triangleCount());
  const std::vector<Leaf> leaves = leavesOf(hierarchy_);
  std::atomic<std::size_t> next{0};
  std::atomic<std::size_t> nextCell{0};
  const std::vector<std::uint8_t> uses =
      hierarchy_.hasCells() ? usesOfVertices(*this, vertexNormals_.size()) : std::vector<std::uint8_t>();
  const std::int64_t most = (kMaxCrossingTests + kMaxCrossingTestsEach * triangleCount()) * kBoxTestsPerTest;
  const std::vector<std::uint32_t> parts = partsOf(*this);
  SelfIntersectionSearch sampled(*this, changed, parts, marks);
  std::atomic<std::int64_t> left{costsMore(leaves, most, sampled) ? 0 : most};
  const auto work = [&] {
    SelfIntersectionSearch search(*this, changed, parts, marks);
    for (std::size_t begin = next.fetch_add(kPiece); begin < leaves.size(); begin = next.fetch_add(kPiece)) {
      interruptionPoint();
      for (const Leaf leaf : std::span(leaves).subspan(begin, std::min(kPiece, leaves.size() - begin))) {
        if (left > 0) left -= search.run(leaf);
      }
    }
    for (std::size_t i = nextCell++; i < hierarchy_.cellCount() && left > 0; i = nextCell++) {
      interruptionPoint();
      left -= search.runCell(hierarchy_.cell(i), uses);
    }
  };
  runInThreads(leaves.size() > kPiece ? threads : 1, work);
  const bool all = left <= 0;  // the sum of all costs, whatever the threads
  for (std::uint32_t t = 0; t < triangleCount(); ++t) {
    if (!all && !marks[t]) continue;
    records_[t].flags |= TriangleRecord::kSelfIntersecting;
    anySelfIntersecting_ = true;
  }
}

}  // namespace haptics

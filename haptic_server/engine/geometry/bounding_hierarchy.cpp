#include "haptic_server/engine/geometry/bounding_hierarchy.h"

#include <algorithm>
#include <atomic>
#include <numeric>

#include "common/interruption/grow.h"
#include "common/interruption/threads.h"
#include "haptic_server/engine/geometry/float_box.h"

namespace haptics {
namespace {

using Box = FloatBox;

/// A thing's box, and in the lane that a box leaves free its number: what is moved when ranges are divided is half a
/// cache line.
class Reference {
 public:
  Reference(const Box& box, std::uint32_t number) noexcept : box_(box) {
    const auto bits = static_cast<int>(number | kNormal);
    box_.low = _mm_castsi128_ps(_mm_insert_epi32(_mm_castps_si128(box.low), bits, kLane));
  }
  [[nodiscard]] const Box& box() const noexcept { return box_; }
  [[nodiscard]] std::uint32_t number() const noexcept {
    return static_cast<std::uint32_t>(_mm_extract_ps(box_.low, kLane)) & ~kNormal;
  }
  [[nodiscard]] __m128 twiceCentre() const noexcept { return _mm_add_ps(box_.low, box_.high); }

 private:
  static constexpr int kLane = 3;
  static constexpr std::uint32_t kNormal = 1U << 30;  // no subnormal float, which takes a processor a hundred cycles
  Box box_;
};

struct Range {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  Box box;

  [[nodiscard]] std::uint32_t size() const noexcept { return end - begin; }
};

/// The cheapest plane between two bins, by the surface area heuristic.
struct Cut {
  int axis = -1;  // -1: all centres coincide
  int bin = 0;    // first on the right
  std::uint32_t leftCount = 0;
  float cost = std::numeric_limits<float>::max();
  Box left;
  Box right;
};

constexpr int kBins = 16;  // per axis and split; 32 changes query times by less than 2 %

struct Binning {
  struct Axis {
    std::array<Box, kBins> box;
    std::array<std::uint32_t, kBins> count{};
  };
  std::array<Axis, 3> axes;
  __m128 origin;  // twice the centres
  __m128 scale;

  /// Along each axis. A range too narrow for float arithmetic makes an infinite scale and any bin at all: the first will
  /// do.
  [[nodiscard]] __m128i binOf(const Reference& r) const noexcept {
    static_assert(std::has_single_bit(static_cast<unsigned>(kBins)));
    const __m128i bin = _mm_cvttps_epi32(_mm_mul_ps(_mm_sub_ps(r.twiceCentre(), origin), scale));
    return _mm_and_si128(bin, _mm_cmpeq_epi32(bin, _mm_and_si128(bin, _mm_set1_epi32(kBins - 1))));
  }
  [[nodiscard]] bool isLeft(const Reference& r, const Cut& cut) const noexcept {
    const __m128i below = _mm_cmplt_epi32(binOf(r), _mm_set1_epi32(cut.bin));
    return (_mm_movemask_ps(_mm_castsi128_ps(below)) >> cut.axis & 1) != 0;
  }
};

void setPlace(BoundingHierarchy::Node& node, std::size_t i, const Box& box) {
  const std::array bounds{stored(box.low), stored(box.high)};
  for (std::size_t side = 0; side < 2; ++side) {
    for (std::size_t d = 0; d < 3; ++d) node.bounds[side][d][i] = bounds[side][d];
  }
}

class Builder {
 public:
  using Child = BoundingHierarchy::Child;
  using Node = BoundingHierarchy::Node;
  using Nodes = std::vector<Node>;

  /// Over `count` things: boxOf(i) is a Box. Leaves hold no more of them than `leaf`; ranges are divided among the free
  /// places of a node down to `divided`.
  template <class BoxOf>
  Builder(std::uint32_t count, std::uint32_t leaf, std::uint32_t divided, BoxOf boxOf)
      : leaf_(leaf), divided_(divided) {
    whole_.end = count;
    references_.reserve(count);
    constexpr std::uint32_t kPiece = 1 << 16;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (i % kPiece == 0) interruptionPoint();
      const Box box = boxOf(i);
      references_.emplace_back(box, i);
      whole_.box.grow(box);
    }
  }

  Nodes build(int threads) {
    Nodes nodes(1);
    const Tasks tasks = fillNode(nodes, 0, whole_, 0);
    std::vector<Nodes> subtrees(tasks.size());
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      for (std::size_t i = next++; i < tasks.size(); i = next++) {
        subtrees[i].resize(1);
        buildBelow(subtrees[i], 0, tasks[i].range, 1);
      }
    };
    constexpr std::uint32_t kWorthThreads = 20'000;  // triangles
    runInThreads(whole_.size() > kWorthThreads ? threads : 1, work);
    for (std::size_t i = 0; i < tasks.size(); ++i) append(nodes, tasks[i], subtrees[i]);
    return nodes;
  }

  [[nodiscard]] LargePageVector<std::uint32_t> order() const {
    LargePageVector<std::uint32_t> order(references_.size());
    std::transform(references_.begin(), references_.end(), order.begin(),
                   [](const Reference& r) { return r.number(); });
    return order;
  }

 private:
  /// An inner place of a node whose subtree is still to be built.
  struct Task {
    std::uint32_t node = 0;
    int place = 0;
    Range range;
  };
  class Tasks {
   public:
    void push_back(const Task& task) { tasks_[count_++] = task; }
    [[nodiscard]] std::size_t size() const noexcept { return count_; }
    const Task& operator[](std::size_t i) const noexcept { return tasks_[i]; }

   private:
    std::array<Task, BoundingHierarchy::kWidth> tasks_;
    std::size_t count_ = 0;
  };

  void buildBelow(Nodes& nodes, std::uint32_t index, const Range& range, int depth) {
    const Tasks tasks = fillNode(nodes, index, range, depth);
    const auto first = static_cast<std::uint32_t>(nodes.size());
    nodes.resize(nodes.size() + tasks.size());
    for (std::uint32_t i = 0; i < tasks.size(); ++i) {
      nodes[index].child[tasks[i].place] = Child::node(first + i);
      buildBelow(nodes, first + i, tasks[i].range, depth + 1);
    }
  }

  static void append(Nodes& nodes, const Task& task, const Nodes& subtree) {
    const auto offset = static_cast<std::uint32_t>(nodes.size());
    nodes[task.node].child[task.place] = Child::node(offset);
    for (Node node : subtree) {
      for (Child& child : node.child) {
        if (!child.isLeaf()) child = Child::node(child.index() + offset);
      }
      nodes.push_back(node);
    }
  }

  /// Splits the range into at most eight: the largest first while the heuristic leads, else the fullest, which bounds
  /// the depth.
  Tasks fillNode(Nodes& nodes, std::uint32_t index, const Range& range, int depth) {
    const bool halve = depth >= BoundingHierarchy::kHeuristicDepth;
    std::array<Range, BoundingHierarchy::kWidth> part;
    part[0] = range;
    std::size_t count = 1;
    while (count < part.size()) {
      interruptionPoint();
      std::size_t widest = part.size();
      float most = -1;
      for (std::size_t i = 0; i < count; ++i) {
        if (part[i].size() < divided_) continue;
        const float size = halve ? static_cast<float>(part[i].size()) : part[i].box.halfArea();
        if (size > most) {
          most = size;
          widest = i;
        }
      }
      if (widest == part.size()) break;
      const auto [left, right] = halve ? halves(part[widest]) : split(part[widest]);
      part[widest] = left;
      part[count++] = right;
    }
    Tasks tasks;
    for (std::size_t i = 0; i < part.size(); ++i) {
      const bool empty = i >= count;
      setPlace(nodes[index], i, empty ? Box{} : part[i].box);
      const bool leaf = !empty && part[i].size() <= leaf_;
      nodes[index].child[i] = leaf ? Child::leaf(part[i].begin, part[i].size()) : Child();
      if (!empty && !leaf) tasks.push_back({index, static_cast<int>(i), part[i]});
    }
    return tasks;
  }

  std::pair<Range, Range> halves(const Range& range) const {
    const std::uint32_t middle = range.begin + range.size() / 2;
    Range left{range.begin, middle, {}};
    Range right{middle, range.end, {}};
    for (std::uint32_t i = range.begin; i < range.end; ++i) (i < middle ? left : right).box.grow(references_[i].box());
    return {left, right};
  }

  std::pair<Range, Range> split(const Range& range) {
    Binning bins;
    fillBins(bins, range);
    const Cut cut = cheapestCut(bins);
    if (cut.axis < 0) return halves(range);
    interruptionPoint();
    const std::uint32_t middle = range.begin + cut.leftCount;
    divide(range, middle, [&](const Reference& r) { return bins.isLeft(r, cut); });
    return {Range{range.begin, middle, cut.left}, Range{middle, range.end, cut.right}};
  }

  /// Puts what is left before the middle, in the order of std::partition(), which guesses at each thing where it lies; half
  /// the guesses are wrong.
  template <class IsLeft>
  void divide(const Range& range, std::uint32_t middle, IsLeft isLeft) {
    constexpr std::uint32_t kBlock = 64;
    std::array<std::uint32_t, kBlock> ups, downs;  // to be exchanged with one another
    std::uint32_t up = 0, upEnd = 0, down = 0, downEnd = 0;
    for (std::uint32_t i = range.begin, j = range.end;;) {
      while (up == upEnd && i < middle) {
        up = upEnd = 0;
        for (const std::uint32_t stop = i + std::min(kBlock, middle - i); i < stop; ++i) {
          ups[upEnd] = i;
          upEnd += isLeft(references_[i]) ? 0 : 1;
        }
      }
      while (down == downEnd && j > middle) {
        down = downEnd = 0;
        for (const std::uint32_t stop = j - std::min(kBlock, j - middle); j > stop;) {
          downs[downEnd] = --j;
          downEnd += isLeft(references_[j]) ? 1 : 0;
        }
      }
      if (up == upEnd || down == downEnd) return;
      while (up < upEnd && down < downEnd) std::swap(references_[ups[up++]], references_[downs[down++]]);
    }
  }

  void fillBins(Binning& bins, const Range& range) const {
    Box centres;
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const __m128 c = references_[i].twiceCentre();
      centres.grow(c, c);
    }
    interruptionPoint();
    constexpr float kBelowLast = kBins * 0.9999F;  // keeps the largest centre in the last bin
    const __m128 width = _mm_sub_ps(centres.high, centres.low);
    bins.origin = centres.low;
    bins.scale = _mm_and_ps(_mm_div_ps(_mm_set1_ps(kBelowLast), width), _mm_cmpgt_ps(width, _mm_setzero_ps()));
    const auto put = [&](const Reference& r) {
      alignas(16) std::array<std::uint32_t, 4> bin;
      _mm_store_si128(reinterpret_cast<__m128i*>(bin.data()), bins.binOf(r));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        bins.axes[axis].box[bin[axis]].grow(r.box());
        ++bins.axes[axis].count[bin[axis]];
      }
    };
    // Neighbours in a range lie side by side: one after the other they would wait for the same bins.
    constexpr std::uint32_t kParts = 4;
    const std::uint32_t part = range.size() / kParts;
    for (std::uint32_t i = range.begin; i < range.begin + part; ++i) {
      for (std::uint32_t k = 0; k < kParts; ++k) put(references_[i + k * part]);
    }
    for (std::uint32_t i = range.begin + kParts * part; i < range.end; ++i) put(references_[i]);
  }

  /// Only bins that hold something are looked at: behind others there is no new cut.
  static Cut cheapestCut(const Binning& bins) {
    Cut best;
    for (int axis = 0; axis < 3; ++axis) {
      const auto& [box, count] = bins.axes[static_cast<std::size_t>(axis)];
      std::array<std::size_t, kBins> held;
      std::size_t heldCount = 0;
      for (std::size_t j = 0; j < kBins; ++j) {
        held[heldCount] = j;
        heldCount += count[j] > 0 ? 1 : 0;
      }
      std::array<Box, kBins> right;
      std::array<std::uint32_t, kBins> rightCount;
      Box sum;
      std::uint32_t total = 0;
      for (std::size_t i = heldCount - 1; i > 0; --i) {
        sum.grow(box[held[i]]);
        right[i] = sum;
        rightCount[i] = total += count[held[i]];
      }
      sum = {};
      total = 0;
      for (std::size_t i = 1; i < heldCount; ++i) {
        sum.grow(box[held[i - 1]]);
        total += count[held[i - 1]];
        const float cost = sum.halfArea() * leaves(total) + right[i].halfArea() * leaves(rightCount[i]);
        if (cost < best.cost) best = {axis, static_cast<int>(held[i - 1]) + 1, total, cost, sum, right[i]};
      }
    }
    return best;
  }
  static float leaves(std::uint32_t triangles) {
    constexpr std::uint32_t kUsualLeaf = 4;  // triangles
    const std::uint32_t count = (triangles + kUsualLeaf - 1) / kUsualLeaf;
    return static_cast<float>(count);
  }

  std::uint32_t leaf_;
  std::uint32_t divided_;
  LargePageVector<Reference> references_;
  Range whole_;
};

[[nodiscard]] Box boxOf(const BoundingHierarchy::Node& node) {
  Box box;
  for (std::size_t i = 0; i < BoundingHierarchy::kWidth; ++i) {
    if (node.bounds[0][0][i] > node.bounds[1][0][i]) continue;
    box.grow(_mm_setr_ps(node.bounds[0][0][i], node.bounds[0][1][i], node.bounds[0][2][i], 0),
             _mm_setr_ps(node.bounds[1][0][i], node.bounds[1][1][i], node.bounds[1][2][i], 0));
  }
  return box;
}

void pad(BoundingHierarchy::Node& node, float by) {
  for (int i = 0; i < BoundingHierarchy::kWidth; ++i) {
    if (node.bounds[0][0][i] > node.bounds[1][0][i]) continue;
    for (int d = 0; d < 3; ++d) {
      node.bounds[0][d][i] -= by;
      node.bounds[1][d][i] += by;
    }
  }
}

}  // namespace

LargePageVector<std::uint32_t> BoundingHierarchy::build(std::span<const Vec3f> vertices,
                                                        std::span<const std::array<std::uint32_t, 3>> triangles,
                                                        double extent_m, int threads) {
  const auto count = static_cast<std::uint32_t>(triangles.size());
  const auto cornersOf = [&](std::uint32_t t) {
    const auto& [a, b, c] = triangles[t];
    return Corners{Vec3(vertices[a]), Vec3(vertices[b]), Vec3(vertices[c])};
  };
  const std::vector<std::uint32_t> inCells = longTriangles(vertices, triangles);
  std::vector<std::uint32_t> others;
  if (!inCells.empty()) {
    std::vector<bool> isLong(count);
    for (const std::uint32_t t : inCells) isLong[t] = true;
    for (std::uint32_t t = 0; t < count; ++t) {
      if (!isLong[t]) others.push_back(t);
    }
  }
  const auto other = [&](std::uint32_t i) { return inCells.empty() ? i : others[i]; };
  firstInCells_ = inCells.empty() ? count : static_cast<std::uint32_t>(others.size());
  nodes_.clear();
  LargePageVector<std::uint32_t> order;
  if (firstInCells_ > 0) {
    Builder builder(firstInCells_, kLeafTriangles, kDivided, [&](std::uint32_t i) {
      const auto& [a, b, c] = triangles[other(i)];
      return Box(vertices[a], vertices[b], vertices[c]);
    });
    const std::vector<Node> nodes = builder.build(threads);
    growTo(nodes_, nodes.size());
    std::ranges::copy(nodes, nodes_.begin());
    order = builder.order();
    if (!inCells.empty()) std::ranges::transform(order, order.begin(), other);
  }
  if (!inCells.empty()) {
    order.insert(order.end(), inCells.begin(), inCells.end());
    appendCells(firstInCells_, count - firstInCells_, [&](std::uint32_t i) { return cornersOf(order[i]); });
  }
  measure(extent_m);
  return order;
}

/// Puts triangles [first, first + count) of the hierarchy's order, whose corners are asked for, into cells, under a root
/// that has the present nodes, if there are any, below it too.
void BoundingHierarchy::appendCells(std::uint32_t first, std::uint32_t count,
                                    const std::function<Corners(std::uint32_t)>& corners) {
  std::vector<std::uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), first);
  TriangleCells cells = cellsOf(numbers, corners);
  Builder builder(static_cast<std::uint32_t>(cells.cells.size()), 1, 2,
                  [&](std::uint32_t i) { return Box(lanes(cells.cells[i].low), lanes(cells.cells[i].high)); });
  const std::vector<Node> below = builder.build(1);
  listed_.clear();
  listEnds_.clear();
  listed_.reserve(cells.listed.size());
  for (const std::uint32_t i : builder.order()) {
    const auto& cell = cells.cells[i];
    listed_.insert(listed_.end(), cells.listed.begin() + cell.begin, cells.listed.begin() + cell.end);
    listEnds_.push_back(static_cast<std::uint32_t>(listed_.size()));
  }
  LargePageVector<Node> present;
  present.swap(nodes_);
  nodes_.resize(1);
  for (std::size_t i = 0; i < kWidth; ++i) setPlace(nodes_.front(), i, Box{});
  firstCellNode_ = static_cast<std::uint32_t>(1 + present.size());
  if (!present.empty()) {
    setPlace(nodes_.front(), 0, boxOf(present.front()));
    nodes_.front().child[0] = Child::node(1);
  }
  setPlace(nodes_.front(), 1, boxOf(below.front()));
  nodes_.front().child[1] = Child::node(firstCellNode_);
  const auto shifted = [](const Node& from, std::uint32_t by) {
    Node node = from;
    for (Child& child : node.child) {
      if (!child.isLeaf()) child = Child::node(child.index() + by);
    }
    return node;
  };
  for (const Node& node : present) nodes_.push_back(shifted(node, 1));
  for (Node node : below) {
    for (Child& child : node.child) {
      if (child.isLeaf()) child = Child::list(child.begin());
    }
    nodes_.push_back(shifted(node, firstCellNode_));
  }
}

void BoundingHierarchy::refit(std::span<const TriangleRecord> triangles, double extent_m) {
  const bool withCells = hasCells();
  if (withCells) dropCells();
  const auto boxOfChild = [&](const Child& child) {
    if (!child.isLeaf()) return boxOf(nodes_[child.index()]);  // comes after this node, so that it has been made
    Box box;
    for (std::uint32_t t = child.begin(); t < child.end(); ++t) {
      box.grow(Box(triangles[t]));
    }
    return box;
  };
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
    interruptionPoint();
    for (std::size_t i = 0; i < kWidth; ++i) {
      if (node->bounds[0][0][i] <= node->bounds[1][0][i]) setPlace(*node, i, boxOfChild(node->child[i]));
    }
  }
  if (withCells) {
    const auto count = static_cast<std::uint32_t>(triangles.size());
    appendCells(firstInCells_, count - firstInCells_, [&](std::uint32_t t) {
      return Corners{triangles[t].corner(0), triangles[t].corner(1), triangles[t].corner(2)};
    });
  }
  measure(extent_m);
}

void BoundingHierarchy::refitInPlace(std::span<const TriangleRecord> triangles, double extent_m) noexcept {
  const auto boxOfChild = [&](const Child& child) {
    if (!child.isLeaf()) return boxOf(nodes_[child.index()]);  // comes after this node, so that it has been made
    Box box;
    if (child.isList()) {
      for (const std::uint32_t t : cell(child.begin())) box.grow(Box(triangles[t]));
    } else {
      for (std::uint32_t t = child.begin(); t < child.end(); ++t) box.grow(Box(triangles[t]));
    }
    return box;
  };
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
    for (std::size_t i = 0; i < kWidth; ++i) {
      if (node->bounds[0][0][i] <= node->bounds[1][0][i]) setPlace(*node, i, boxOfChild(node->child[i]));
    }
  }
  measure(extent_m);
}

/// Only what is about the other triangles is left.
void BoundingHierarchy::dropCells() {
  LargePageVector<Node> left;
  for (std::uint32_t i = 1; i < firstCellNode_; ++i) {
    left.push_back(nodes_[i]);
    for (Child& child : left.back().child) {
      if (!child.isLeaf()) child = Child::node(child.index() - 1);
    }
  }
  nodes_.swap(left);
}

/// Pads every box, and measures the root's.
void BoundingHierarchy::measure(double extent_m) {
  low_ = Vec3(std::numeric_limits<double>::infinity());
  high_ = -low_;
  for (Node& node : nodes_) pad(node, static_cast<float>(extent_m * kBoxPad));
  const Node& root = nodes_.front();
  for (int i = 0; i < kWidth; ++i) {
    if (root.bounds[0][0][i] > root.bounds[1][0][i]) continue;
    for (int d = 0; d < 3; ++d) {
      low_[d] = std::min<double>(low_[d], root.bounds[0][d][i]);
      high_[d] = std::max<double>(high_[d], root.bounds[1][d][i]);
    }
  }
  const Vec3 size = high_ - low_;
  short_ = kShort * std::max({size.x, size.y, size.z});
}

}  // namespace haptics

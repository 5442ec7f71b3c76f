#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "common/maths/vec.h"

namespace haptics {

/// Along the axes; holds nothing at first.
struct Box {
  Vec3f low{std::numeric_limits<float>::infinity()};
  Vec3f high{-std::numeric_limits<float>::infinity()};

  void join(const Box& other) noexcept {
    low = glm::min(low, other.low);
    high = glm::max(high, other.high);
  }
  [[nodiscard]] bool meets(const Box& other) const noexcept {
    return low.x <= other.high.x && low.y <= other.high.y && low.z <= other.high.z && other.low.x <= high.x &&
           other.low.y <= high.y && other.low.z <= high.z;
  }
};

/// Items in the leaves of a complete binary tree of boxes, whose nodes are numbered from 1: the children of i are 2 i and
/// 2 i + 1. A node's items are halved by number across the longest side of the box about their middles, so that no
/// range of sizes makes it lopsided.
class BoxTree {
 public:
  static constexpr std::size_t kRoot = 1;
  static constexpr std::size_t kMaxInLeaf = 8;
  using BoxOf = std::function<Box(std::uint32_t item)>;

  /// Items are numbered from 0.
  BoxTree(std::uint32_t count, BoxOf boxOf);

  /// To be called when the boxes of these items changed.
  void refit(std::span<const std::uint32_t> items);

  [[nodiscard]] const Box& box(std::size_t node) const noexcept { return boxes_[node]; }
  [[nodiscard]] bool isLeaf(std::size_t node) const noexcept { return node >= leaves_; }
  [[nodiscard]] std::span<const std::uint32_t> leaf(std::size_t node) const noexcept {
    const std::size_t begin = beginOf(node - leaves_);
    return std::span(order_).subspan(begin, beginOf(node - leaves_ + 1) - begin);
  }

 private:
  struct Middle;

  [[nodiscard]] std::size_t beginOf(std::size_t leaf) const noexcept { return leaf * order_.size() / leaves_; }
  void arrange(std::vector<Middle>& middles, std::size_t firstLeaf, std::size_t leaves) const;
  void fit(std::size_t node);

  BoxOf boxOf_;
  std::size_t leaves_;                 // a power of two
  std::vector<std::uint32_t> order_;   // items, leaf by leaf
  std::vector<std::uint32_t> leafOf_;  // of each item; from the first refit on
  std::vector<Box> boxes_;
};

}  // namespace haptics

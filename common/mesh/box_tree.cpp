#include "common/mesh/box_tree.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "common/interruption/interruption.h"

namespace haptics {

struct BoxTree::Middle {
  Vec3f at;
  std::uint32_t item;
};

BoxTree::BoxTree(std::uint32_t count, BoxOf boxOf)
    : boxOf_(std::move(boxOf)),
      leaves_(std::bit_ceil((std::max<std::size_t>(count, 1) + kMaxInLeaf - 1) / kMaxInLeaf)),
      order_(count),
      boxes_(2 * leaves_) {
  std::vector<Middle> middles(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Box box = boxOf_(i);
    middles[i] = {0.5F * box.low + 0.5F * box.high, i};
  }
  arrange(middles, 0, leaves_);
  std::ranges::transform(middles, order_.begin(), &Middle::item);
  for (std::size_t node = boxes_.size() - 1; node > 0; --node) fit(node);
}

/// Brings the items of these leaves to them.
void BoxTree::arrange(std::vector<Middle>& middles, std::size_t firstLeaf, std::size_t leaves) const {
  if (leaves == 1) return;
  interruptionPoint();
  const auto at = [&](std::size_t leaf) { return middles.begin() + static_cast<std::ptrdiff_t>(beginOf(leaf)); };
  const auto begin = at(firstLeaf), half = at(firstLeaf + leaves / 2), end = at(firstLeaf + leaves);
  Box around;
  for (auto middle = begin; middle != end; ++middle) around.join({middle->at, middle->at});
  const Vec3 size = Vec3(around.high) - Vec3(around.low);
  const int longest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  std::nth_element(begin, half, end,
                   [longest](const Middle& a, const Middle& b) { return a.at[longest] < b.at[longest]; });
  arrange(middles, firstLeaf, leaves / 2);
  arrange(middles, firstLeaf + leaves / 2, leaves / 2);
}

void BoxTree::fit(std::size_t node) {
  interruptionPoint();
  Box box;
  if (isLeaf(node)) {
    for (const std::uint32_t item : leaf(node)) box.join(boxOf_(item));
  } else {
    box = boxes_[2 * node];
    box.join(boxes_[2 * node + 1]);
  }
  boxes_[node] = box;
}

void BoxTree::refit(std::span<const std::uint32_t> items) {
  if (leafOf_.empty()) {
    leafOf_.resize(order_.size());
    for (std::size_t node = leaves_; node < boxes_.size(); ++node) {
      for (const std::uint32_t item : leaf(node)) leafOf_[item] = static_cast<std::uint32_t>(node);
    }
  }
  std::vector<std::size_t> nodes;
  for (const std::uint32_t item : items) nodes.push_back(leafOf_[item]);
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

}  // namespace haptics
